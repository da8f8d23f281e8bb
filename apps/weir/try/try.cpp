// `weir try MODEL INPUT`: runs a model on a photo, video, camera or stream and shows the results.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <cstdio>

#include "commands.hpp"
#include "core/text/shell_quote.hpp"
#include "report.hpp"
#include "run/diagnostics.hpp"
#include "run/pipeline_run.hpp"
#include "try/try_model.hpp"
#include "try/try_pipeline.hpp"
#include "weir/printable_text.hpp"

namespace weir::app {
namespace {

constexpr char kTextSink[] = "fakesink name=weir-try-text sync=false";

// The label of a class, "class 5" where it has no name and its number is the label.
std::string name_of_class(const Json& object, const std::string& label) {
  const bool is_number =
      object.contains("index") && (label.empty() || label == object["index"].dump());
  return is_number ? "class " + object["index"].dump() : label;
}

// No "-0" for what lies a little outside the picture.
double whole(const Json& number) {
  return std::round(number.get<double>()) + 0.0;
}

// "person 93 %  12,30 to 200,400".
std::string make_line(const Json& object, const char* name_key) {
  const auto text = [&](const char* key) {
    return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
  };
  const std::string name = name_of_class(object, text(name_key));
  char number[64] = "";
  if (object.contains("score"))
    std::snprintf(number, sizeof number, " %.0f %%", object["score"].get<double>() * 100);
  std::string out = name + number;
  if (object.contains("track")) out += " #" + object["track"].dump();
  if (object.contains("box") && object["box"].size() == 4) {
    const auto& box = object["box"];
    std::snprintf(number, sizeof number, "  %.0f,%.0f to %.0f,%.0f", whole(box[0]), whole(box[1]),
                  whole(box[2]), whole(box[3]));
    out += number;
  }
  return out;
}

// "cat 34 % of the picture", "depth 0.2 to 31, mean 4.5".
std::vector<std::string> lines_of_maps(const Json& frame) {
  std::vector<std::string> out;
  char text[96];
  for (const Json& segment : frame.value("segments", Json::array())) {
    std::snprintf(text, sizeof text, " %.0f %% of the picture", segment.value("part", 0.0) * 100);
    out.push_back(name_of_class(segment, segment.value("label", "")) + text);
  }
  for (const Json& depth : frame.value("depth", Json::array())) {
    std::snprintf(text, sizeof text, "depth %.4g to %.4g, mean %.4g", depth.value("least", 0.0),
                  depth.value("greatest", 0.0), depth.value("mean", 0.0));
    out.push_back(text);
  }
  return out;
}

// Labels come from files and models.
void print_line(const std::string& line) {
  std::printf("  %s\n", printable_text(line).c_str());
}

void print_frame(const std::string& text) {
  const Json frame = Json::parse(text, nullptr, false);
  if (!frame.is_object()) return;
  char time[32] = "";
  if (frame.contains("time") && frame["time"].is_number())
    std::snprintf(time, sizeof time, "%.2f s", frame["time"].get<double>());
  std::printf("%s\n", time);
  bool is_empty = true;
  for (const auto& [list, name] :
       {std::pair{"labels", "label"}, {"detections", "label"}, {"text", "text"}}) {
    if (!frame.contains(list)) continue;
    for (const Json& object : frame[list]) {
      print_line(make_line(object, name));
      is_empty = false;
    }
  }
  for (const std::string& line : lines_of_maps(frame)) {
    print_line(line);
    is_empty = false;
  }
  if (is_empty) std::puts("  nothing");
  std::fflush(stdout);
}

GstPadProbeReturn on_results(GstPad*, GstPadProbeInfo* info, gpointer user) {
  GstMapInfo map;
  GstBuffer* buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  if (!gst_buffer_map(buffer, &map, GST_MAP_READ)) return GST_PAD_PROBE_OK;
  const std::string text(reinterpret_cast<const char*>(map.data), map.size);
  gst_buffer_unmap(buffer, &map);
  if (*static_cast<const bool*>(user)) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  } else {
    print_frame(text);
  }
  return GST_PAD_PROBE_OK;
}

// The same with the option of this command in place of custom=head:NAME. Fixes with settings of a
// head, or without a head, are for pipelines only.
Diagnostic with_own_options(Diagnostic found) {
  std::string& fix = found.error.fix;
  if (fix.find(',') != std::string::npos || fix.find(" without ") != std::string::npos)
    return found;
  for (const std::string_view text : {"tensor_decoder custom=head:", "custom=head:"})
    for (size_t at = 0; (at = fix.find(text, at)) != std::string::npos;)
      fix.replace(at, text.size(), "--head ");
  return found;
}

}  // namespace

int try_model_on_input(const TryOptions& options) {
  const auto model = try_model(options);
  if (!model) return report(model.error(), false);
  const auto shown = try_pipeline(options, *model, "fdsink fd=1");
  if (!shown) return report(shown.error(), false);
  const auto played = try_pipeline(options, *model, kTextSink);
  auto pipeline = played->make();
  if (!pipeline) return report(pipeline.error(), false);
  if (auto opened = open_window(pipeline->get()); !opened) {
    gst_element_set_state(pipeline->get(), GST_STATE_NULL);
    return report(opened.error(), false);
  }
  for (const auto& note : model->notes) std::fprintf(stderr, "%s\n", printable_text(note).c_str());
  std::fprintf(stderr, "gst-launch-1.0 %s\n\n", shown->pasted().c_str());
  {
    const auto sink =
        gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline->get()), "weir-try-text"));
    const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(sink.get(), "sink"));
    gst_pad_add_probe(pad.get(), GST_PAD_PROBE_TYPE_BUFFER, on_results,
                      const_cast<bool*>(&options.json), nullptr);
  }
  auto adopted = PlayedPipeline::make(*std::move(pipeline));
  if (!adopted) return report(adopted.error(), false);
  PipelineRun run(*std::move(adopted));
  if (options.show && is_photo(options.input)) run.stop_at_first_signal();
  const RunEnd ending = run.play(
      {.progress = {},
       .notice =
           [](const std::string& text) {
             std::fprintf(stderr, "%s\n", printable_text(text).c_str());
           },
       .warning = [](const Diagnostic& warning) { print_warning(with_own_options(warning)); },
       .playing = {},
       .stopping = {}});
  if (ending == RunEnd::Error && run.errors().front().is_closed_window) return kExitGood;
  auto errors = run.errors();
  for (auto& error : errors) error = with_own_options(std::move(error));
  print_errors(errors);
  if (!options.output.empty() && ending == RunEnd::Eos)
    std::fprintf(stderr, "%s\n", options.output.c_str());
  if (ending == RunEnd::Eos) return kExitGood;
  return ending == RunEnd::Error ? kExitError : kExitInterrupted;
}

}  // namespace weir::app
