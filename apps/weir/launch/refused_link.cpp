// Finds the link by the names in the message, and tries converting elements by their pad templates.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/refused_link.hpp"

#include <gst/gst.h>

#include <map>

#include "core/text/error_text.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/element/ref.hpp"
#include "launch/launch_graph.hpp"

namespace weir::app {
namespace {

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

gst::Ref<GstElementFactory> factory_of(const std::string& type) {
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
    const auto factory = factory_of(element.type);
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
  const auto factory = factory_of(type);
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

// "" when none fits.
std::string converter_between(GstCaps* from, GstCaps* to) {
  for (const auto& converter : kConverters) {
    const bool decodes = std::string_view(converter.first) == "decodebin";
    if (decodes && is_raw(from)) continue;  // its pad takes any caps
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
  if (converter.empty()) return out;
  const std::string inserted = converter + " ! ";
  const std::string mended = text.substr(0, link->at) + inserted + text.substr(link->at);
  if (!links_up_to(mended, link->at + inserted.size())) return out;
  out.needed = converter + " between them, which converts the stream";
  out.fix = mended;
  return out;
}

}  // namespace weir::app
