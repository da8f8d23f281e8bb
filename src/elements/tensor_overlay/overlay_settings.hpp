// OverlaySettings: the properties of tensor_overlay.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <tuple>

#include "core/draw/trails.hpp"
#include "elements/tensor_overlay/results_pad.hpp"
#include "gstcpp/element/property.hpp"

namespace weir {

enum class ColorBy : int32_t { Class, Track };

namespace gst {
template <>
struct EnumType<ColorBy> {
  static GType type() {
    static const GEnumValue values[] = {{0, "The class of an object", "class"},
                                        {1, "The track of an object, else its class", "track"},
                                        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirOverlayColorBy", values);
    return t;
  }
};
template <>
struct EnumType<Coordinates> {
  static GType type() {
    static const GEnumValue values[] = {
        {0, "Pixels of the picture", "picture"},
        {1, "Pixels of the tensor to which the source map of the results refers", "tensor"},
        {0, nullptr, nullptr}};
    static const GType t = g_enum_register_static("WeirOverlayCoordinates", values);
    return t;
  }
};
}  // namespace gst

struct OverlaySettings {
  ResultsSync sync = ResultsSync::Newest;
  uint64_t max_age = 1000000000;
  uint64_t max_wait = 1000000000;
  Coordinates coordinates = Coordinates::Picture;
  std::string labels;
  bool show_scores = true;
  uint32_t text_size = 20;
  uint32_t line_width = 2;
  uint32_t point_size = 5;
  float min_score = 0;
  float mask_opacity = 0.45f;
  bool auto_size = true;
  ColorBy color_by = ColorBy::Class;
  uint32_t trail_length = 0;
  bool show_zones = true;
};

inline constexpr uint64_t kMaxNanoseconds = uint64_t{24} * 3600 * 1000000000;

inline constexpr std::tuple kOverlayProperties{
    gst::Property{"sync", &OverlaySettings::sync, "Which results are drawn on a picture"},
    gst::Property{"max-age", &OverlaySettings::max_age,
                  "With sync=newest: maximum time difference in nanoseconds between a picture and "
                  "the results that are drawn on it; 0 = results are drawn until others arrive",
                  gst::Changeable::WhilePlaying},
    gst::Property{"max-wait", &OverlaySettings::max_wait,
                  "With sync=same-time: maximum time in nanoseconds that a picture waits for its "
                  "results; after that it is pushed without them",
                  gst::Changeable::InReady, uint64_t{0}, kMaxNanoseconds},
    gst::Property{"coordinates", &OverlaySettings::coordinates, "Coordinate system of the results"},
    gst::Property{"labels", &OverlaySettings::labels,
                  "Path of a text file with one class name per line, the first for class 0; for "
                  "results of several models one file each, separated by ';'"},
    gst::Property{"show-scores", &OverlaySettings::show_scores,
                  "Write the score of each box in per cent, after its name if it has one"},
    gst::Property{"text-size", &OverlaySettings::text_size,
                  "Font size of labels in pixels; unless set, see auto-size",
                  gst::Changeable::InReady, 6u, 200u},
    gst::Property{"line-width", &OverlaySettings::line_width,
                  "Line width of boxes in pixels, drawn inwards; 0 = no boxes; unless set, see "
                  "auto-size",
                  gst::Changeable::WhilePlaying, 0u, 256u},
    gst::Property{"point-size", &OverlaySettings::point_size,
                  "Diameter of key points in pixels; 0 = no points; unless set, see auto-size",
                  gst::Changeable::WhilePlaying, 0u, 256u},
    gst::Property{"mask-opacity", &OverlaySettings::mask_opacity,
                  "Opacity of masks and class maps, 0 to 1; 0 = none",
                  gst::Changeable::WhilePlaying, 0.0f, 1.0f},
    gst::Property{
        "auto-size", &OverlaySettings::auto_size,
        "Scale text-size, line-width and point-size with the height of the picture unless they are "
        "set: 20, 2 and 5 at 720 rows; false = these sizes at any height"},
    gst::Property{"color-by", &OverlaySettings::color_by,
                  "What selects the colour of boxes and labels", gst::Changeable::WhilePlaying},
    gst::Property{"trail-length", &OverlaySettings::trail_length,
                  "Number of results over which the trail of a track extends; 0 = no trails",
                  gst::Changeable::WhilePlaying, 0u, draw::kTrailLimit},
    gst::Property{"show-zones", &OverlaySettings::show_zones,
                  "Draw the zones of tensor_zones with their names and counts",
                  gst::Changeable::WhilePlaying},
    gst::Property{"min-score", &OverlaySettings::min_score,
                  "Minimum score of the results that are drawn", gst::Changeable::WhilePlaying,
                  0.0f, 1e30f},
};

}  // namespace weir
