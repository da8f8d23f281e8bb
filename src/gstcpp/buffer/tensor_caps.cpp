// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/tensor_caps.hpp"

#include <algorithm>
#include <climits>
#include <cstring>
#include <string>
#include <vector>

#include "gstcpp/element/error.hpp"
#include "gstcpp/element/log.hpp"
#include "weir/results.h"

namespace weir::gst {
namespace {

enum class Name { Tensor, Tensors };

Fraction get_rate(const GstStructure* s) {
  Fraction rate;
  gst_structure_get_fraction(s, "framerate", &rate.numerator, &rate.denominator);
  return rate;
}

Status read_lists(const GstStructure* s, const char* dims_field, const char* types_field,
                  FrameSpec* spec) {
  const char* dims = gst_structure_get_string(s, dims_field);
  const char* types = gst_structure_get_string(s, types_field);
  std::vector<Shape> shapes;
  std::vector<ElementType> element_types;
  if (dims) {
    auto parsed = parse_shape_list(dims);
    if (!parsed) return parsed.error();
    shapes = *std::move(parsed);
  }
  if (types) {
    auto parsed = parse_type_list(types);
    if (!parsed) return parsed.error();
    element_types = *std::move(parsed);
  }
  spec->tensors.resize(std::max({shapes.size(), element_types.size(), spec->tensors.size()}));
  for (size_t i = 0; i < shapes.size(); ++i) spec->tensors[i].shape = shapes[i];
  for (size_t i = 0; i < element_types.size(); ++i) spec->tensors[i].type = element_types[i];
  return ok();
}

Format get_format(const GstStructure* s) {
  if (const char* text = gst_structure_get_string(s, "format")) return parse_format(text);
  if (gst_structure_has_field(s, "format"))
    return Format::End;  // a list in caps that are not fixed
  if (!gst_structure_has_field(s, "num_tensors")) return Format::End;
  GST_CAT_WARNING(gst::library_category(),
                  "caps %" GST_PTR_FORMAT " have num_tensors without a format: treated as static",
                  static_cast<const void*>(s));
  return Format::Static;
}

void set_rate(GstStructure* s, const Fraction& rate) {
  if (rate.valid())
    gst_structure_set(s, "framerate", GST_TYPE_FRACTION, rate.numerator, rate.denominator, nullptr);
  else
    gst_structure_set(s, "framerate", GST_TYPE_FRACTION_RANGE, 0, 1, G_MAXINT, 1, nullptr);
}

bool all_shapes_known(const FrameSpec& spec) {
  return !spec.tensors.empty() && std::all_of(spec.tensors.begin(), spec.tensors.end(),
                                              [](const auto& t) { return t.shape.valid(); });
}
bool all_types_known(const FrameSpec& spec) {
  return !spec.tensors.empty() &&
         std::all_of(spec.tensors.begin(), spec.tensors.end(),
                     [](const auto& t) { return t.type != ElementType::End; });
}

std::string cut_to_rank_4(const FrameSpec& spec) {
  std::vector<TensorSpec> cut = spec.tensors;
  for (auto& t : cut)
    if (t.shape.rank() > 4) t.shape = t.shape.with_rank(4);
  return join_shapes(cut);
}

// The natural rank, cut to rank 4, and padded to rank 4 (docs/compatibility/types-and-caps.md 1.5).
std::vector<std::string> spellings(const FrameSpec& spec) {
  std::vector<std::string> out{join_shapes(spec.tensors)};
  const bool short_enough = std::all_of(spec.tensors.begin(), spec.tensors.end(),
                                        [](const auto& t) { return t.shape.min_rank() <= 4; });
  if (!short_enough) return out;
  const auto add = [&out](std::string text) {
    if (std::find(out.begin(), out.end(), text) == out.end()) out.push_back(std::move(text));
  };
  add(cut_to_rank_4(spec));
  std::vector<TensorSpec> cut = spec.tensors;
  for (auto& t : cut) t.shape = t.shape.with_rank(4);
  add(join_shapes(cut));
  return out;
}

bool same_shapes(const char* text, const FrameSpec& spec) {
  const auto parsed = parse_shape_list(text);
  if (!parsed || parsed->size() != spec.tensors.size()) return false;
  for (size_t i = 0; i < parsed->size(); ++i)
    if (!((*parsed)[i] == spec.tensors[i].shape)) return false;
  return true;
}

bool same_types(const char* text, const FrameSpec& spec) {
  const auto parsed = parse_type_list(text);
  return parsed &&
         std::equal(parsed->begin(), parsed->end(), spec.tensors.begin(), spec.tensors.end(),
                    [](ElementType type, const auto& t) { return type == t.type; });
}

const char* dimensions_field(Name name) {
  return name == Name::Tensor ? "dimension" : "dimensions";
}
const char* types_field(Name name) {
  return name == Name::Tensor ? "type" : "types";
}

// The peer's own spelling of an equal list; the last one wins. "" if there is none.
std::string peer_spelling(Name name, const char* field, const FrameSpec& spec, const GstCaps* peer,
                          bool (*same)(const char*, const FrameSpec&)) {
  std::string found;
  if (!peer || gst_caps_is_any(peer)) return found;
  const char* media = name == Name::Tensor ? "other/tensor" : "other/tensors";
  for (guint i = 0; i < gst_caps_get_size(peer); ++i) {
    const GstStructure* s = gst_caps_get_structure(peer, i);
    if (!gst_structure_has_name(s, media)) continue;
    const char* text = gst_structure_get_string(s, field);
    if (text && same(text, spec)) found = text;
  }
  return found;
}

std::string types_text(Name name, const FrameSpec& spec, const GstCaps* peer) {
  const std::string spelled = peer_spelling(name, types_field(name), spec, peer, same_types);
  return spelled.empty() ? join_types(spec.tensors) : spelled;
}

// One text for each structure; "" if a shape is unknown.
std::vector<std::string> dimensions_texts(Name name, const FrameSpec& spec, const GstCaps* peer) {
  if (!all_shapes_known(spec)) return {""};
  const std::string spelled = peer_spelling(name, dimensions_field(name), spec, peer, same_shapes);
  return spelled.empty() ? spellings(spec) : std::vector{spelled};
}

void append_static(GstCaps* caps, Name name, const FrameSpec& spec, const GstCaps* peer) {
  for (const auto& dims : dimensions_texts(name, spec, peer)) {
    GstStructure* s =
        gst_structure_new_empty(name == Name::Tensor ? "other/tensor" : "other/tensors");
    if (name == Name::Tensors) {
      gst_structure_set(s, "format", G_TYPE_STRING, "static", nullptr);
      if (spec.tensors.empty())
        gst_structure_set(s, "num_tensors", GST_TYPE_INT_RANGE, 1, int{kTensorLimit}, nullptr);
      else
        gst_structure_set(s, "num_tensors", G_TYPE_INT, static_cast<int>(spec.tensors.size()),
                          nullptr);
    }
    if (!dims.empty())
      gst_structure_set(s, dimensions_field(name), G_TYPE_STRING, dims.c_str(), nullptr);
    if (all_types_known(spec))
      gst_structure_set(s, types_field(name), G_TYPE_STRING, types_text(name, spec, peer).c_str(),
                        nullptr);
    set_rate(s, spec.rate);
    gst_caps_append_structure(caps, s);
  }
}

Ref<GstCaps> with_name(Name name, const FrameSpec& spec, const GstCaps* peer) {
  auto caps = Ref<GstCaps>::adopt(gst_caps_new_empty());
  append_static(caps.get(), name, spec, peer);
  return caps;
}

Ref<GstCaps> with_format(Format format, const Fraction& rate) {
  GstStructure* s = gst_structure_new("other/tensors", "format", G_TYPE_STRING,
                                      std::string(to_string(format)).c_str(), nullptr);
  set_rate(s, rate);
  auto caps = Ref<GstCaps>::adopt(gst_caps_new_empty());
  gst_caps_append_structure(caps.get(), s);
  return caps;
}

// The number of tensors that the caps set; 0 if they do not.
Result<size_t> parse_count(const GstStructure* s) {
  int count = 0;
  if (!gst_structure_get_int(s, "num_tensors", &count)) return size_t{0};
  if (count < 1 || count > int{kTensorLimit})
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "num_tensors is out of range",
                 .offered = std::to_string(count),
                 .needed = "1 to 256"};
  return static_cast<size_t>(count);
}

}  // namespace

Result<FrameSpec> spec_from_caps(const GstCaps* caps) {
  if (!caps || gst_caps_is_any(caps) || gst_caps_is_empty(caps))
    return Error{
        .code = Code::NOT_NEGOTIATED, .what = "the caps are empty", .needed = "other/tensors"};
  const GstStructure* s = gst_caps_get_structure(caps, 0);
  FrameSpec spec;
  spec.rate = get_rate(s);
  if (gst_structure_has_name(s, "other/tensor")) {
    spec.format = Format::Static;
    spec.tensors.resize(1);
    if (auto status = read_lists(s, "dimension", "type", &spec); !status) return status.error();
    if (spec.tensors.size() > 1)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "other/tensor caps hold one tensor only",
                   .offered = spec.to_string(),
                   .needed = "one dimension and one type",
                   .fix = "use other/tensors"};
    return spec;
  }
  if (!gst_structure_has_name(s, "other/tensors"))
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "the caps are not those of a tensor stream",
                 .offered = gst_structure_get_name(s),
                 .needed = "other/tensor or other/tensors",
                 .fix = "tensor_converter"};
  spec.format = get_format(s);
  if (spec.format != Format::Static) return spec;
  const auto count = parse_count(s);
  if (!count) return count.error();
  spec.tensors.resize(*count);
  if (auto status = read_lists(s, "dimensions", "types", &spec); !status) return status.error();
  if (*count > 0 && spec.tensors.size() != *count) {
    GST_CAT_WARNING(gst::library_category(), "num_tensors and the lists differ in %" GST_PTR_FORMAT,
                    static_cast<const void*>(s));
    spec.tensors.resize(*count);
  }
  return spec;
}

namespace {

// "" unless dimensions are flags, as GStreamer reads dimensions=640:3.
std::string flags_instead_of_dimensions(const GstCaps* caps) {
  for (guint i = 0; caps && i < gst_caps_get_size(caps); ++i)
    for (const char* name : {"dimensions", "dimension"}) {
      const GValue* value = gst_structure_get_value(gst_caps_get_structure(caps, i), name);
      if (value && g_type_is_a(G_VALUE_TYPE(value), GST_TYPE_FLAG_SET))
        return std::string(name) + "=A:B without (string) is a set of flags; write " + name +
               "=(string)A:B";
    }
  return "";
}

}  // namespace

Result<FrameSpec> fixed_spec_from_caps(const GstCaps* caps) {
  auto spec = spec_from_caps(caps);
  if (!spec) return spec;
  const UniqueText text{gst_caps_to_string(caps)};
  if (!gst_caps_is_fixed(caps))
    return Error{.code = Code::NOT_NEGOTIATED,
                 .what = "the caps are not fixed",
                 .offered = text.get(),
                 .needed = "one value for every field",
                 .difference = flags_instead_of_dimensions(caps)};
  if (!spec->valid())
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "the caps do not describe the tensors completely",
                 .offered = text.get(),
                 .needed = "a framerate, and for each tensor a type and a dimension",
                 .fix =
                     "other/tensors,format=static,num_tensors=1,dimensions=3:224:224:1,types=uint8,"
                     "framerate=30/1"};
  if (spec->format == Format::Static && !spec->bytes())
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the tensors of the caps are too big",
                 .offered = text.get(),
                 .needed = "a size that fits into 63 bits"};
  return spec;
}

ResultRoles roles_from_caps(const GstCaps* caps) {
  if (!caps || gst_caps_is_any(caps) || gst_caps_is_empty(caps)) return {};
  const GstStructure* s = gst_caps_get_structure(caps, 0);
  const char* columns = gst_structure_get_string(s, WEIR_RESULTS_COLUMNS);
  const char* sources = gst_structure_get_string(s, WEIR_RESULTS_SOURCE);
  return parse_roles(columns ? columns : "", sources ? sources : "");
}

Ref<GstCaps> with_roles(Ref<GstCaps> caps, const ResultRoles& roles) {
  for (guint i = 0; i < gst_caps_get_size(caps.get()); ++i)
    gst_structure_remove_fields(gst_caps_get_structure(caps.get(), i), WEIR_RESULTS_COLUMNS,
                                WEIR_RESULTS_SOURCE, nullptr);
  if (roles.empty()) return caps;
  gst_caps_set_simple(caps.get(), WEIR_RESULTS_COLUMNS, G_TYPE_STRING, columns_text(roles).c_str(),
                      WEIR_RESULTS_SOURCE, G_TYPE_STRING, sources_text(roles).c_str(), nullptr);
  return caps;
}

Ref<GstCaps> possible_caps(GstPad* pad, const FrameSpec& spec, const GstCaps* peer) {
  auto all = Ref<GstCaps>::adopt(gst_caps_new_empty());
  const auto template_caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(pad));
  const auto add = [&](const Ref<GstCaps>& caps) {
    for (guint i = 0; i < gst_caps_get_size(caps.get()); ++i) {
      auto one = Ref<GstCaps>::adopt(gst_caps_copy_nth(caps.get(), i));
      if (gst_caps_can_intersect(one.get(), template_caps.get()))
        gst_caps_append(all.get(), one.release());
    }
  };
  if (spec.format == Format::Static || spec.format == Format::End) {
    if (spec.tensors.size() <= 1) add(with_name(Name::Tensor, spec, peer));
    add(with_name(Name::Tensors, spec, peer));
  }
  if (spec.format == Format::Sparse)
    add(with_format(Format::Sparse, spec.rate));
  else
    add(with_format(Format::Flexible, spec.rate));
  return with_roles(std::move(all), spec.roles);
}

Ref<GstCaps> without_dimensions(Ref<GstCaps> caps) {
  auto open = Ref<GstCaps>::adopt(gst_caps_make_writable(caps.release()));
  for (guint i = 0; i < gst_caps_get_size(open.get()); ++i)
    gst_structure_remove_fields(gst_caps_get_structure(open.get(), i), "dimension", "dimensions",
                                nullptr);
  return open;
}

PeerCaps::PeerCaps(GstPad* source_pad)
    : caps(Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source_pad, nullptr))) {
  GstCaps* const peer = caps.get();
  if (!gst_pad_is_linked(source_pad) || !peer || gst_caps_is_any(peer) || gst_caps_is_empty(peer))
    return;
  const auto single = Ref<GstCaps>::adopt(gst_caps_from_string(WEIR_CAPS_TENSOR));
  takes_single = gst_caps_can_intersect(peer, single.get());
  const GstStructure* first = gst_caps_get_structure(peer, 0);
  const char* format = gst_structure_get_string(first, "format");
  flexible = gst_structure_has_name(first, "other/tensors") && format &&
             parse_format(format) == Format::Flexible;
}

namespace {

// Pushing caps succeeds whatever downstream elements answer, and only Weir's elements post why they
// reject caps. They accept all caps in the query for which they can post an error in the event.
bool were_accepted_or_reported(GstPad* source_pad, GstCaps* caps) {
  const auto linked = Ref<GstPad>::adopt(gst_pad_get_peer(source_pad));
  if (linked && !gst_pad_query_accept_caps(linked.get(), caps)) return false;
  const uint64_t errors_before = errors_posted_by_this_thread();
  log_output_caps(source_pad, caps);
  gst_pad_push_event(source_pad, gst_event_new_caps(caps));
  if (!linked || GST_PAD_IS_FLUSHING(source_pad)) return true;  // its element is shutting down
  const auto taken = Ref<GstCaps>::adopt(gst_pad_get_current_caps(linked.get()));
  if (taken && gst_caps_is_equal(taken.get(), caps)) return true;
  if (errors_posted_by_this_thread() != errors_before) return true;
  const auto wanted = Ref<GstCaps>::adopt(gst_pad_query_caps(linked.get(), nullptr));
  return gst_caps_can_intersect(caps, wanted.get());  // an element downstream holds the event back
}

}  // namespace

std::string caps_to_paste(const FrameSpec& spec) {
  std::string out = "other/tensors,format=" + std::string(to_string(spec.format));
  if (spec.format != Format::Static) return out;
  return out + ",dimensions=(string)\"" + join_shapes(spec.tensors) + "\",types=(string)\"" +
         join_types(spec.tensors) + "\"";
}

Error downstream_mismatch(const std::string& name, const GstCaps* peer, std::string offered,
                          std::string fix) {
  const UniqueText needed{gst_caps_to_string(peer)};
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the element downstream of " + name + " does not accept its output",
               .offered = std::move(offered),
               .needed = needed.get(),
               .difference = flags_instead_of_dimensions(peer),
               .fix = std::move(fix)};
}

Error downstream_mismatch(GstPad* source_pad, const GstCaps* peer, std::string offered,
                          std::string fix) {
  const auto parent = Ref<GstObject>::adopt(gst_pad_get_parent(source_pad));
  GstElementFactory* factory = parent && GST_IS_ELEMENT(parent.get())
                                   ? gst_element_get_factory(GST_ELEMENT(parent.get()))
                                   : nullptr;
  return downstream_mismatch(factory ? GST_OBJECT_NAME(factory) : "this one", peer,
                             std::move(offered), std::move(fix));
}

bool downstream_accepts(GstPad* source_pad, const PeerCaps& peer, GstCaps* caps) {
  if (!caps) return false;
  if (!gst_pad_is_linked(source_pad)) return true;
  // The two queries differ: tensor_filter answers one for caps that do not fit its model with its
  // template, and tensor_transform leaves the dimensions open without a filter.
  const auto some = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source_pad, caps));
  return gst_caps_can_intersect(caps, peer.caps.get()) &&
         gst_caps_can_intersect(caps, some.get()) &&
         (!gst_caps_is_fixed(caps) || gst_pad_peer_query_accept_caps(source_pad, caps));
}

namespace {

std::string make_caps_fix(const GstCaps* caps) {
  if (const auto spec = spec_from_caps(caps); spec && spec->info_valid())
    return caps_to_paste(*spec);
  return UniqueText(gst_caps_to_string(caps)).get();
}

}  // namespace

Status check_downstream(GstPad* source_pad, GstCaps* caps, std::string fix) {
  const PeerCaps peer(source_pad);
  if (downstream_accepts(source_pad, peer, caps)) return ok();
  if (fix.empty()) fix = make_caps_fix(caps);
  return downstream_mismatch(source_pad, peer.caps.get(),
                             UniqueText(gst_caps_to_string(caps)).get(), std::move(fix));
}

Status check_downstream(GstPad* source_pad, const FrameSpec& spec, std::string fix) {
  const PeerCaps peer(source_pad);
  if (downstream_accepts(source_pad, peer, choose_caps(source_pad, peer, spec).get())) return ok();
  return downstream_mismatch(source_pad, peer.caps.get(), spec.to_string(), std::move(fix));
}

Status send_caps(GstPad* source_pad, const FrameSpec& spec, GstCaps* caps) {
  if (caps && were_accepted_or_reported(source_pad, caps)) return ok();
  const auto peer = Ref<GstCaps>::adopt(gst_pad_peer_query_caps(source_pad, nullptr));
  Error error = downstream_mismatch(source_pad, peer.get(), spec.to_string(), caps_to_paste(spec));
  const auto wanted = spec_from_caps(peer.get());
  if (wanted && wanted->info_valid())
    error.difference = first_difference(spec.tensors, wanted->tensors);
  return error;
}

Ref<GstCaps> choose_caps(GstPad* source_pad, const PeerCaps& peer, const FrameSpec& spec,
                         bool may_add_headers) {
  const auto template_caps = Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(source_pad));
  Ref<GstCaps> caps;
  if (spec.format == Format::Flexible || (peer.flexible && may_add_headers)) {
    caps = with_format(Format::Flexible, spec.rate);
  } else if (spec.format == Format::Sparse) {
    caps = with_format(Format::Sparse, spec.rate);
  } else {
    if (spec.tensors.size() == 1 && peer.takes_single) {
      caps = with_name(Name::Tensor, spec, peer.caps.get());
      if (!gst_caps_can_intersect(caps.get(), template_caps.get())) caps = {};
    }
    if (!caps) caps = with_name(Name::Tensors, spec, peer.caps.get());
  }
  auto meet = Ref<GstCaps>::adopt(gst_caps_intersect(caps.get(), template_caps.get()));
  if (gst_caps_is_empty(meet.get())) return {};
  return with_roles(Ref<GstCaps>::adopt(gst_caps_truncate(meet.release())), spec.roles);
}

}  // namespace weir::gst
