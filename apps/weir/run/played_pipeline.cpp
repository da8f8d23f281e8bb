// SPDX-License-Identifier: LGPL-2.1-or-later
#include "run/played_pipeline.hpp"

#include <string>
#include <utility>

#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/property_text.hpp"

namespace weir::app {

Result<PlayedPipeline> PlayedPipeline::make(gst::Ref<GstElement> element) {
  auto pipeline = Pipeline::adopt(element.get());
  if (!pipeline) return pipeline.error();
  // The command does not pull their frames.
  for (const auto& each : gst::elements_in(element.get())) {
    const std::string kind = gst::get_factory_name(each.get());
    if (kind != "appsink" && kind != "tensor_sink") continue;
    if (auto status = pipeline->discard(GST_OBJECT_NAME(each.get())); !status)
      return status.error();
  }
  auto bus = gst::Ref<GstBus>::adopt(gst_bus_new());
  auto status = pipeline->on_message(
      [bus](GstMessage* message) { gst_bus_post(bus.get(), gst_message_ref(message)); });
  if (!status) return status.error();
  return PlayedPipeline{std::move(element), std::move(bus), *std::move(pipeline)};
}

std::vector<Diagnostic> PlayedPipeline::take_errors() const {
  std::vector<Diagnostic> out;
  while (GstMessage* message = gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR)) {
    out.push_back(parse_diagnostic(message));
    gst_message_unref(message);
  }
  return out;
}

}  // namespace weir::app
