// Knows the elements that need a second plug-in, and those of NNStreamer that Weir does not have.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/missing_element.hpp"

#include <gst/gst.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "launch/launch_tokens.hpp"

namespace weir::app {
namespace {

struct Lacking {
  std::string_view name, alternative;
};
// Elements of NNStreamer; a build that has one never looks it up here.
constexpr std::array kLacking{
    Lacking{"tensor_src_iio", "appsrc in a program that reads the sensor, with caps other/tensors"},
    Lacking{"tensor_trainer", "tensor_filter, with a model that was trained elsewhere"},
    Lacking{"datareposrc", "multifilesrc ! application/octet-stream ! tensor_converter"},
    Lacking{"datareposink", "multifilesink, which writes the bytes of each frame to a file"},
};

// Elements that a build without an optional library lacks.
struct Optional {
  std::string_view name, needed, fix;
};
constexpr std::string_view kGrpc = "apt-get install libgrpc++-dev && make install";
constexpr std::string_view kMosquitto = "apt-get install libmosquitto-dev && make install";
constexpr std::array kOptional{
    Optional{"tensor_sink_grpc", "the plug-in weirnet: a build of Weir with gRPC", kGrpc},
    Optional{"tensor_src_grpc", "the plug-in weirnet: a build of Weir with gRPC", kGrpc},
    Optional{"mqttsink", "a build of Weir with libmosquitto", kMosquitto},
    Optional{"mqttsrc", "a build of Weir with libmosquitto", kMosquitto},
};

template <class Table>
auto find(const Table& table, const std::string& name) {
  return std::find_if(table.begin(), table.end(),
                      [&](const auto& row) { return row.name == name; });
}

std::vector<std::string> installed_elements() {
  std::vector<std::string> out;
  GList* list = gst_registry_get_feature_list(gst_registry_get(), GST_TYPE_ELEMENT_FACTORY);
  for (GList* item = list; item; item = item->next)
    out.emplace_back(gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(item->data)));
  gst_plugin_feature_list_free(list);
  return out;
}

constexpr std::string_view kFamily = "tensor_";

// Names that begin with "tensor_" are compared by the rest, which tells them apart.
std::string nearest_element(const std::string& name) {
  const bool of_family = name.starts_with(kFamily);
  std::vector<std::string> candidates;
  for (const auto& element : installed_elements())
    if (element.starts_with(kFamily) == of_family)
      candidates.push_back(of_family ? element.substr(kFamily.size()) : element);
  const std::string close = nearest(of_family ? name.substr(kFamily.size()) : name, candidates);
  return of_family && !close.empty() ? std::string(kFamily) + close : close;
}

// Where the element is in the text, other than as part of another word.
std::optional<size_t> place_of(const std::string& name, const std::string& text) {
  const auto tokens = launch_tokens(text);
  if (!tokens) return std::nullopt;
  for (const auto& token : *tokens)
    if (token.text == name) return token.at;
  return std::nullopt;
}

}  // namespace

Error missing_element(const std::string& name, const std::string& text) {
  Error out{.code = Code::OPTION_SYNTAX,
            .what = "the element " + name + " is not installed",
            .needed = "an element that gst-inspect-1.0 lists"};
  const auto at = place_of(name, text);
  const std::string place = at ? place_in(text, *at) : "";
  out.difference = place;
  if (const auto lacking = find(kLacking, name); lacking != kLacking.end()) {
    out.what = "Weir has no element " + name + " of NNStreamer";
    out.needed = std::string(lacking->alternative);
    return out;
  }
  if (const auto optional = find(kOptional, name); optional != kOptional.end()) {
    out.needed = std::string(optional->needed);
    out.fix = std::string(optional->fix);
    return out;
  }
  const std::string close = nearest_element(name);
  if (close.empty() && name.starts_with(kFamily)) out.fix = "weir doctor";
  if (close.empty() || !at) return out;
  out.difference = "did you mean " + close + "? " + place;
  out.fix = text.substr(0, *at) + close + text.substr(*at + name.size());
  return out;
}

}  // namespace weir::app
