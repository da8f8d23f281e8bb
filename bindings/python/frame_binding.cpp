// weir.Frame: a frame that came out of a pipeline, with its arrays, results and source maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frame_binding.hpp"

#include <pybind11/stl.h>

#include <memory>

#include "arrays.hpp"
#include "weir/pipeline.hpp"

namespace weir::bindings {
namespace {

std::optional<int64_t> to_number(const std::optional<Nanoseconds>& time) {
  return time ? std::optional<int64_t>(time->count()) : std::nullopt;
}

py::array get_tensor(const Frame& frame, py::ssize_t index) {
  const auto size = static_cast<py::ssize_t>(frame.size());
  if (index < 0) index += size;
  if (index < 0 || index >= size) throw py::index_error("the frame has no such tensor");
  auto kept = std::make_unique<Frame>(frame);
  const Tensor tensor = (*kept)[static_cast<size_t>(index)];
  const py::capsule owner(kept.get(), [](void* end) { delete static_cast<Frame*>(end); });
  kept.release();
  return make_array(tensor, owner);
}

py::object make_maps(const Frame& frame) {
  return py::tuple(py::cast(frame.source_maps()));
}

std::optional<SourceMap> first_map(const Frame& frame) {
  const auto maps = frame.source_maps();
  return maps.empty() ? std::nullopt : std::optional(maps.front());
}

py::object get_label(const Frame& frame, size_t tensor, int32_t class_index) {
  const std::string label = frame.label(tensor, class_index);
  if (label.empty()) return py::none();
  // Labels come from files: bytes that are not UTF-8 are replaced.
  return py::bytes(label).attr("decode")("utf-8", "replace");
}

// A property that a function of weir.results computes from the frame.
auto from_results(const char* function) {
  return [function](const py::object& frame) {
    return py::module_::import("weir.results").attr(function)(frame);
  };
}

std::string repr(const Frame& frame) {
  std::string out = "<weir.Frame";
  if (const auto pts = frame.pts()) out += " pts=" + std::to_string(pts->count());
  for (size_t i = 0; i < frame.size(); ++i)
    out += (i > 0 ? ", " : ": ") + frame[i].info().to_string();
  return out + ">";
}

std::string repr_of_map(const SourceMap& map) {
  const auto size = [](uint32_t width, uint32_t height) {
    return std::to_string(width) + "x" + std::to_string(height);
  };
  return "<weir.SourceMap from " + size(map.width, map.height) + " to " +
         size(map.source_width, map.source_height) + ">";
}

void bind_source_map(py::module_& module) {
  py::class_<SourceMap>(module, "SourceMap",
                        R"(The transform from tensor to source picture coordinates.

Coordinates are pixels from the top left corner. Integers are the edges between pixels.)")
      .def(
          "to_source",
          [](const SourceMap& map, double x, double y) {
            const Point point = map.to_source({x, y});
            return py::make_tuple(point.x, point.y);
          },
          py::arg("x"), py::arg("y"), "Returns the point (x, y) of the source picture.")
      .def(
          "to_tensor",
          [](const SourceMap& map, double x, double y) {
            const Point point = map.to_tensor({x, y});
            return py::make_tuple(point.x, point.y);
          },
          py::arg("x"), py::arg("y"), "Returns the point (x, y) of the tensor.")
      .def_property_readonly(
          "source_size",
          [](const SourceMap& map) { return py::make_tuple(map.source_width, map.source_height); },
          "(width, height) of the picture")
      .def_property_readonly(
          "size", [](const SourceMap& map) { return py::make_tuple(map.width, map.height); },
          "(width, height) of the tensor, in pixels")
      .def_property_readonly(
          "matrix",
          [](const SourceMap& m) {
            return py::make_tuple(py::make_tuple(m.xx, m.xy, m.x0),
                                  py::make_tuple(m.yx, m.yy, m.y0));
          },
          "((xx, xy, x0), (yx, yy, y0)): source x = xx * x + xy * y + x0, and y likewise")
      .def("__repr__", &repr_of_map);
}

constexpr const char* kFrame = R"(A frame from a pipeline.

len(frame) is the number of its tensors. frame[i] is a read-only array over the memory of a tensor. `pts` and `duration` are in
nanoseconds, or None. A frame of other media is one array of uint8.)";

}  // namespace

void bind_frame(py::module_& module) {
  bind_source_map(module);
  py::class_<Frame>(module, "Frame", kFrame)
      .def("__len__", &Frame::size)
      .def("__getitem__", &get_tensor, py::arg("index"))
      .def("__iter__",
           [](const py::object& frame) {
             return py::reinterpret_steal<py::object>(PySeqIter_New(frame.ptr()));
           })
      .def_property_readonly(
          "pts", [](const Frame& f) { return to_number(f.pts()); },
          "the timestamp in nanoseconds, or None")
      .def_property_readonly(
          "duration", [](const Frame& f) { return to_number(f.duration()); },
          "in nanoseconds, or None")
      .def_property_readonly("caps", &Frame::caps, "the stream's caps, as GStreamer writes them")
      .def_property_readonly("results", from_results("of_frame"),
                             "the results of tensor_decoder, tensor_tracker and others: a list of "
                             "weir.results.Row. Raises ValueError if the stream has no results")
      .def_property_readonly("columns", from_results("columns_of_frame"),
                             "the description of each tensor: a list of weir.results.Columns")
      .def_property_readonly("text", from_results("text_of_frame"),
                             "the frame of a text stream, such as that of tensor_decoder "
                             "mode=json, as str. Raises ValueError for other streams")
      .def_property_readonly("source_map", &first_map,
                             "the SourceMap of the first tensor or region, or None if the frame "
                             "does not come from a picture")
      .def_property_readonly("source_maps", &make_maps,
                             "the SourceMaps: one for all tensors, one for each tensor, or one for "
                             "each region of a batch of regions")
      .def("caps_field", &Frame::caps_field, py::arg("name"),
           "Returns the text of a caps field, such as weir-source, or \"\" if it does not exist.")
      .def("label", &get_label, py::arg("tensor"), py::arg("class_index"),
           "Returns the label of a class in results tensor number `tensor`, or None.")
      .def("__repr__", &repr);
}

}  // namespace weir::bindings
