// Reads pad templates from GStreamer's registry, which needs no element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/missing_pad.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
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
  const size_t most = conversion->characters.empty()
                          ? pad.size()
                          : std::min(pad.find_first_not_of(conversion->characters), pad.size());
  for (size_t length = most; length > 0; --length)
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

// The name with `number` for each conversion.
std::string numbered(std::string name, const std::string& number) {
  while (const auto conversion = next_conversion(name))
    name.replace(conversion->begin, conversion->end - conversion->begin, number);
  return name;
}

// The digits of a name that was meant, as 9 of "src_9z"; else the first number that is free.
std::string example_of(const std::string& name, const std::string& meant,
                       const std::set<std::string>& used) {
  const size_t begin = meant.find_first_of(kDigits);
  if (begin != std::string::npos) {
    const size_t end = meant.find_first_not_of(kDigits, begin);
    return numbered(name, meant.substr(begin, end == std::string::npos ? end : end - begin));
  }
  size_t number = 0;
  while (used.contains(numbered(name, std::to_string(number)))) ++number;
  return numbered(name, std::to_string(number));
}

// The names of pads of the element in the text. Links that name none take the first numbers.
std::set<std::string> used_pads(const LaunchGraph& graph, const NamedPad& end,
                                const std::vector<std::string>& templates) {
  const bool is_source = end.direction == GST_PAD_SRC;
  std::set<std::string> out;
  size_t number = 0;
  for (const size_t index : is_source ? end.element.outputs : end.element.inputs) {
    const LaunchLink& link = graph.links[index];
    const std::string& pad = (is_source ? link.from_pad : link.to_pad).name;
    out.insert(pad);
    if (!pad.empty()) continue;
    for (const auto& name : templates) out.insert(numbered(name, std::to_string(number)));
    ++number;
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

std::optional<Error> check(const std::string& text, const LaunchGraph& graph, GstElement* parsed,
                           const NamedPad& end) {
  const std::string& pad = end.pad.name;
  const auto names = template_names(end.element.type, end.direction);
  const bool is_known =
      pad.empty() || names.empty() || has_pad(parsed, end) ||
      std::any_of(names.begin(), names.end(), [&](const auto& name) { return fits(pad, name); });
  if (is_known) return std::nullopt;
  const auto used = used_pads(graph, end, names);
  std::vector<std::string> examples;
  examples.reserve(names.size());
  for (const auto& name : names) examples.push_back(example_of(name, pad, used));
  const std::string close = examples.size() == 1 ? examples[0] : nearest(pad, examples);
  Error out{.code = Code::OPTION_SYNTAX,
            .what = end.element.type + " has no " + end.kind() + " with the name " + pad,
            .needed = std::string("a ") + end.kind() + " of " + end.element.type + ": " +
                      join(names, " or "),
            .difference = place_in(text, end.pad.at)};
  if (!close.empty() && text.compare(end.pad.at, pad.size(), pad) == 0)
    out.fix = text.substr(0, end.pad.at) + close + text.substr(end.pad.at + pad.size());
  return out;
}

}  // namespace

std::optional<Error> missing_pad(const std::string& text, GstElement* parsed) {
  const auto graph = read_launch_graph(text);
  if (!graph) return std::nullopt;
  for (const auto& link : graph->links) {
    const NamedPad ends[]{{graph->elements[link.from], link.from_pad, GST_PAD_SRC},
                          {graph->elements[link.to], link.to_pad, GST_PAD_SINK}};
    for (const auto& end : ends)
      if (auto error = check(text, *graph, parsed, end)) return error;
  }
  return std::nullopt;
}

}  // namespace weir::app
