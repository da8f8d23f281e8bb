// Reads pad templates from GStreamer's registry, which needs no element; finds a refused link by
// the names in the message.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/refused_link.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <vector>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/element/ref.hpp"
#include "launch/launch_graph.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr std::string_view kDigits = "0123456789";

// One end of a link that names a pad.
struct NamedPad {
  const LaunchElement& element;
  const LaunchPad& pad;
  GstPadDirection direction;
  const char* kind() const { return direction == GST_PAD_SRC ? "source pad" : "sink pad"; }
};

// A conversion of a template's name, as %u in "sink_%u" and %02x in "video_%02x".
struct Conversion {
  size_t begin = 0, end = 0;
  std::string_view characters;  // that it stands for; "": any
};

std::optional<Conversion> next_conversion(std::string_view name) {
  const size_t begin = name.find('%');
  if (begin == std::string_view::npos) return std::nullopt;
  const size_t kind = std::min(name.find_first_not_of(kDigits, begin + 1), name.size() - 1);
  const char letter = name[kind];
  return Conversion{begin, kind + 1,
                    letter == 'u'   ? kDigits
                    : letter == 'd' ? "-0123456789"
                    : letter == 'x' ? "0123456789abcdefABCDEF"
                                    : ""};
}

// Whether a pad of the template can have the name.
bool fits(std::string_view pad, std::string_view name) {
  const auto conversion = next_conversion(name);
  if (!conversion) return pad == name;
  if (pad == name) return true;  // GStreamer counts for "mux.sink_%u"
  if (!pad.starts_with(name.substr(0, conversion->begin))) return false;
  pad.remove_prefix(conversion->begin);
  const size_t max = conversion->characters.empty()
                         ? pad.size()
                         : std::min(pad.find_first_not_of(conversion->characters), pad.size());
  for (size_t length = max; length > 0; --length)
    if (fits(pad.substr(length), name.substr(conversion->end))) return true;
  return false;
}

std::vector<std::string> template_names(const std::string& type, GstPadDirection direction) {
  std::vector<std::string> out;
  const auto factory = gst::Ref<GstElementFactory>::adopt(gst_element_factory_find(type.c_str()));
  if (!factory) return out;
  for (const GList* item = gst_element_factory_get_static_pad_templates(factory.get()); item;
       item = item->next) {
    const auto* pad = static_cast<const GstStaticPadTemplate*>(item->data);
    if (pad->direction == direction) out.emplace_back(pad->name_template);
  }
  return out;
}

// Whether an element of this type has a pad of the direction from the beginning.
bool has_always_pad(const std::string& type, GstPadDirection direction) {
  const auto factory = gst::Ref<GstElementFactory>::adopt(gst_element_factory_find(type.c_str()));
  if (!factory) return false;
  for (const GList* item = gst_element_factory_get_static_pad_templates(factory.get()); item;
       item = item->next) {
    const auto* pad = static_cast<const GstStaticPadTemplate*>(item->data);
    if (pad->direction == direction && pad->presence == GST_PAD_ALWAYS) return true;
  }
  return false;
}

// The name with `number` for each conversion.
std::string numbered(std::string name, const std::string& number) {
  while (const auto conversion = next_conversion(name))
    name.replace(conversion->begin, conversion->end - conversion->begin, number);
  return name;
}

// The digits of a name that was meant, as 9 of "src_9z"; else the first number that is free. ""
// when a pad without a number is linked already.
std::string make_example(const std::string& name, const std::string& meant,
                         const std::set<std::string>& used) {
  if (!next_conversion(name)) return used.contains(name) ? "" : name;
  const size_t begin = meant.find_first_of(kDigits);
  if (begin != std::string::npos) {
    const size_t end = meant.find_first_not_of(kDigits, begin);
    return numbered(name, meant.substr(begin, end == std::string::npos ? end : end - begin));
  }
  size_t number = 0;
  while (used.contains(numbered(name, std::to_string(number)))) ++number;
  return numbered(name, std::to_string(number));
}

// The names of pads of the element in the text. Links that name none take the first numbers, or the
// only pad without a number.
std::set<std::string> used_pads(const LaunchGraph& graph, const NamedPad& end,
                                const std::vector<std::string>& templates) {
  const bool is_source = end.direction == GST_PAD_SRC;
  std::vector<std::string> singles;
  std::copy_if(templates.begin(), templates.end(), std::back_inserter(singles),
               [](const auto& name) { return !next_conversion(name); });
  std::set<std::string> out;
  size_t number = 0;
  for (const size_t index : is_source ? end.element.outputs : end.element.inputs) {
    const LaunchLink& link = graph.links[index];
    const std::string& pad = (is_source ? link.from_pad : link.to_pad).name;
    out.insert(pad);
    if (!pad.empty()) continue;
    for (const auto& name : templates)
      if (next_conversion(name)) out.insert(numbered(name, std::to_string(number)));
    ++number;
    if (singles.size() == 1) out.insert(singles[0]);
  }
  return out;
}

bool has_pad(GstElement* parsed, const NamedPad& end) {
  if (!parsed || !GST_IS_BIN(parsed)) return false;
  const auto element =
      gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(parsed), end.element.name.c_str()));
  return element &&
         gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), end.pad.name.c_str()));
}

std::optional<Error> check_pad(const std::string& text, const LaunchGraph& graph,
                               GstElement* parsed, const NamedPad& end) {
  const std::string& pad = end.pad.name;
  const auto names = template_names(end.element.type, end.direction);
  const bool is_known =
      pad.empty() || names.empty() || has_pad(parsed, end) ||
      std::any_of(names.begin(), names.end(), [&](const auto& name) { return fits(pad, name); });
  if (is_known) return std::nullopt;
  const auto used = used_pads(graph, end, names);
  std::vector<std::string> examples;
  for (const auto& name : names)
    if (auto example = make_example(name, pad, used); !example.empty())
      examples.push_back(std::move(example));
  const std::string close =
      names.size() == 1 && !examples.empty() ? examples[0] : nearest(pad, examples);
  Error out{.code = Code::OPTION_SYNTAX,
            .what = end.element.type + " has no " + end.kind() + " with the name " + pad,
            .needed = std::string("a ") + end.kind() + " of " + end.element.type + ": " +
                      join(names, " or ") + (examples.empty() ? "; it is linked already" : ""),
            .difference = place_in(text, end.pad.at)};
  if (!close.empty() && text.compare(end.pad.at, pad.size(), pad) == 0)
    out.fix = text.substr(0, end.pad.at) + close + text.substr(end.pad.at + pad.size());
  return out;
}

// In this order: the first that fits is proposed.
struct Converter {
  const char* text;
  const char* first;   // the element that takes the stream
  const char* output;  // the element whose output leaves, or its caps
};
constexpr Converter kConverters[] = {
    {"videoconvert ! videoscale", "videoconvert", "videoscale"},
    {"audioconvert ! audioresample", "audioconvert", "audioresample"},
    {"tensor_converter", "tensor_converter", "tensor_converter"},
    {"tensor_decoder mode=direct_video", "tensor_decoder", "video/x-raw,format={RGB,BGRx,GRAY8}"},
    {"decodebin", "decodebin", "decodebin"},
};

// The parts of GStreamer's message.
struct RefusedNames {
  std::string from, to;
  std::string refusing;  // the element that "can't handle caps"; "" if it is not said
  std::string caps;
};

std::optional<RefusedNames> parse(const std::string& message) {
  constexpr std::string_view kBegin = "could not link ", kTo = " to ",
                             kCaps = " can't handle caps ";
  const size_t to = message.find(kTo);
  if (!message.starts_with(kBegin) || to == std::string::npos) return std::nullopt;
  const size_t comma = message.find(", ", to), caps = message.find(kCaps, to);
  RefusedNames out;
  out.from = message.substr(kBegin.size(), to - kBegin.size());
  out.to =
      message.substr(to + kTo.size(), comma == std::string::npos ? comma : comma - to - kTo.size());
  if (comma == std::string::npos || caps == std::string::npos) return out;
  out.refusing = message.substr(comma + 2, caps - comma - 2);
  out.caps = message.substr(caps + kCaps.size());
  return out;
}

gst::Ref<GstElementFactory> find_factory(const std::string& type) {
  auto found = gst::Ref<GstElementFactory>::adopt(gst_element_factory_find(type.c_str()));
  if (!found) return found;
  return gst::Ref<GstElementFactory>::adopt(
      GST_ELEMENT_FACTORY(gst_plugin_feature_load(GST_PLUGIN_FEATURE(found.get()))));
}

// The names that GStreamer gave the elements: those of name=, or the class in small letters without
// "Gst" and a number that counts from the one of the message.
class Names {
 public:
  explicit Names(const LaunchGraph& graph) {
    for (const auto& element : graph.elements) {
      const bool is_named = element.name != element.type + std::to_string(element.number);
      names_.push_back(is_named ? element.name : default_name(element));
    }
  }
  const std::string& operator[](size_t element) const { return names_[element]; }

 private:
  static std::string default_name(const LaunchElement& element) {
    const auto factory = find_factory(element.type);
    if (!factory) return "";
    std::string name = g_type_name(gst_element_factory_get_element_type(factory.get()));
    if (name.starts_with("Gst")) name.erase(0, 3);
    const gst::UniqueText lower(g_ascii_strdown(name.c_str(), -1));
    return lower.get() + std::to_string(element.number);
  }
  std::vector<std::string> names_;
};

gst::Ref<GstCaps> template_caps(const char* type, GstPadDirection direction) {
  auto out = gst::Ref<GstCaps>::adopt(gst_caps_new_empty());
  const auto factory = find_factory(type);
  if (!factory) return out;
  for (const GList* item = gst_element_factory_get_static_pad_templates(factory.get()); item;
       item = item->next) {
    auto* pad = static_cast<GstStaticPadTemplate*>(item->data);
    if (pad->direction != direction) continue;
    out = gst::Ref<GstCaps>::adopt(
        gst_caps_merge(out.release(), gst_static_pad_template_get_caps(pad)));
  }
  return out;
}

bool can_link(GstCaps* from, GstCaps* to) {
  return gst_caps_can_intersect(from, to) != FALSE;
}

bool is_raw(GstCaps* caps) {
  const auto raw = gst::Ref<GstCaps>::adopt(
      gst_caps_from_string("video/x-raw; audio/x-raw; text/x-raw; other/tensor; other/tensors"));
  return can_link(caps, raw.get());
}

// Whether decodebin has an element that reads the caps.
bool can_decode(GstCaps* caps) {
  if (is_raw(caps)) return false;
  GList* const all =
      gst_element_factory_list_get_elements(GST_ELEMENT_FACTORY_TYPE_DECODABLE, GST_RANK_MARGINAL);
  GList* const fit = gst_element_factory_list_filter(all, caps, GST_PAD_SINK, FALSE);
  const bool out = fit != nullptr;
  gst_plugin_feature_list_free(fit);
  gst_plugin_feature_list_free(all);
  return out;
}

// "" when none fits.
std::string converter_between(GstCaps* from, GstCaps* to) {
  for (const auto& converter : kConverters) {
    const bool decodes = std::string_view(converter.first) == "decodebin";
    if (decodes && !can_decode(from)) continue;  // its pad takes any caps
    const auto output = std::string_view(converter.output).find('/') == std::string_view::npos
                            ? template_caps(converter.output, GST_PAD_SRC)
                            : gst::Ref<GstCaps>::adopt(gst_caps_from_string(converter.output));
    if (can_link(from, template_caps(converter.first, GST_PAD_SINK).get()) &&
        can_link(output.get(), to))
      return converter.text;
  }
  return "";
}

std::optional<LaunchLink> find_link(const LaunchGraph& graph, const RefusedNames& refused) {
  const Names names(graph);
  for (const auto& link : graph.links)
    if (names[link.from] == refused.from && names[link.to] == refused.to) return link;
  return std::nullopt;
}

std::string without_number(const std::string& name) {
  return name.substr(0, name.find_last_not_of("0123456789") + 1);
}

// Whether the link to the element at `place` can be made; there may be further mistakes after it.
// GStreamer goes on counting when it names the elements of a second pipeline.
bool links_up_to(const std::string& text, size_t place) {
  GError* raw = nullptr;
  GstElement* made =
      gst_parse_launch_full(text.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &raw);
  const gst::Unique<GError, g_error_free> error(raw);
  if (made) gst_object_unref(gst_object_ref_sink(made));
  if (!error || !g_error_matches(error.get(), GST_PARSE_ERROR, GST_PARSE_ERROR_LINK)) return true;
  const auto refused = parse(error->message);
  const auto graph = read_launch_graph(text);
  if (!refused || !graph) return false;
  const Names names(*graph);
  const auto is_same = [&names](size_t element, const std::string& name) {
    return without_number(names[element]) == without_number(name);
  };
  for (const auto& link : graph->links)
    if (is_same(link.from, refused->from) && is_same(link.to, refused->to)) return link.at > place;
  return false;
}

// "application/x-event-stream" -> "event-stream", as `weir new` takes names: a letter first, 64
// characters, not "auto" or "any".
std::string make_converter_name(const std::string& media_type) {
  constexpr size_t kMaxName = 64;
  std::string out;
  for (const char c : lower(media_type.substr(media_type.find('/') + 1)))
    out += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  if (out.starts_with("x-")) out.erase(0, 2);
  out.erase(0, out.find_first_of("abcdefghijklmnopqrstuvwxyz"));
  out.resize(std::min(out.size(), kMaxName));
  return out.empty() || out == "auto" || out == "any" ? "my-converter" : out;
}

// For a stream that only a converter of the user can read.
void propose_converter(GstCaps* offered, Error* out) {
  if (gst_caps_is_any(offered) || gst_caps_is_empty(offered) || is_raw(offered)) return;
  const std::string type = gst_structure_get_name(gst_caps_get_structure(offered, 0));
  out->needed = "a module that converts " + type +
                ", in a folder of WEIR_MODULE_PATH; the fix makes the source of one "
                "(docs/guide/use-a-sensor.md)";
  out->fix = "weir new converter " + make_converter_name(type);
}

}  // namespace

std::optional<Error> refused_link(const std::string& text, const std::string& message) {
  const auto refused = parse(message);
  const auto graph = read_launch_graph(text);
  if (!refused || !graph) return std::nullopt;
  const auto link = find_link(*graph, *refused);
  if (!link) return std::nullopt;
  const std::string& from = graph->elements[link->from].type;
  const std::string& to = graph->elements[link->to].type;
  // The caps of a capsfilter between them, if it is the downstream element that refuses them.
  const bool has_caps = refused->refusing == refused->to;
  auto written = gst::caps_from_text(refused->caps);
  const auto offered = !has_caps ? template_caps(from.c_str(), GST_PAD_SRC)
                       : written ? *std::move(written)
                                 : gst::Ref<GstCaps>();
  const auto needed = template_caps(to.c_str(), GST_PAD_SINK);
  // The caps of the capsfilter are what the upstream element cannot make.
  const bool is_caps = !refused->refusing.empty() && refused->refusing == refused->from;
  Error out{.code = Code::OPTION_SYNTAX,
            .what = from + " cannot be linked to " + to,
            .difference = message + " " + place_in(text, is_caps ? link->caps_at : link->at)};
  const bool is_usual = refused->refusing.empty() || has_caps;
  if (!offered || !is_usual) return out;
  const std::string converter = converter_between(offered.get(), needed.get());
  if (converter.empty() && to == "tensor_converter" && has_caps)
    propose_converter(offered.get(), &out);
  if (converter.empty()) return out;
  const std::string inserted = converter + " ! ";
  const std::string mended = text.substr(0, link->at) + inserted + text.substr(link->at);
  if (!links_up_to(mended, link->at + inserted.size())) return out;
  out.needed = converter + " between them, which converts the stream";
  out.fix = mended;
  return out;
}

std::optional<Error> missing_link(const std::string& text) {
  const auto graph = read_launch_graph(text);
  if (!graph) return std::nullopt;
  for (size_t i = 0; i + 1 < graph->elements.size(); ++i) {
    const auto &from = graph->elements[i], &to = graph->elements[i + 1];
    if (!from.outputs.empty() || !to.inputs.empty()) continue;
    if (!has_always_pad(from.type, GST_PAD_SRC) || !has_always_pad(to.type, GST_PAD_SINK)) continue;
    return Error{.code = Code::OPTION_SYNTAX,
                 .what = from.type + " and " + to.type + " are not linked",
                 .needed = "a ! between them",
                 .difference = place_in(text, to.at),
                 .fix = text.substr(0, to.at) + "! " + text.substr(to.at)};
  }
  return std::nullopt;
}

std::optional<Error> dimensions_without_type(const std::string& text) {
  constexpr std::string_view kHexadecimal = "0123456789abcdefABCDEF";
  for (const std::string_view key : {"dimensions=", "dimension="})
    for (size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
      const size_t begin = at + key.size();
      const size_t colon = text.find_first_not_of(kHexadecimal, begin);
      if (colon == std::string::npos || colon == begin || text[colon] != ':') continue;
      const size_t end = std::min(text.find_first_not_of(kHexadecimal, colon + 1), text.size());
      constexpr std::string_view kEnds = " \t\n,;!'\"", kBegins = " \t\n,;'\"";
      const bool is_value = end == text.size() || kEnds.find(text[end]) != std::string_view::npos;
      const bool is_field = at > 0 && kBegins.find(text[at - 1]) != std::string_view::npos;
      if (end == colon + 1 || !is_value || !is_field) continue;
      return Error{.code = Code::OPTION_SYNTAX,
                   .what = "dimensions of two numbers without a type are flags for GStreamer",
                   .offered = text.substr(at, end - at),
                   .needed = std::string(key) + "(string)" + text.substr(begin, end - begin),
                   .difference = place_in(text, at),
                   .fix = text.substr(0, begin) + "(string)" + text.substr(begin)};
    }
  return std::nullopt;
}

std::optional<Error> missing_pad(const std::string& text, GstElement* parsed) {
  const auto graph = read_launch_graph(text);
  if (!graph) return std::nullopt;
  for (const auto& link : graph->links) {
    const NamedPad ends[]{{graph->elements[link.from], link.from_pad, GST_PAD_SRC},
                          {graph->elements[link.to], link.to_pad, GST_PAD_SINK}};
    for (const auto& end : ends)
      if (auto error = check_pad(text, *graph, parsed, end)) return error;
  }
  return std::nullopt;
}

}  // namespace weir::app
