// Chooses the source, the encoder and the branches.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/try_pipeline.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "core/text/pasted.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

std::string extension_of(const std::string& path) {
  return lower(fs::path(path).extension().string());
}

constexpr char kWindow[] = "window";

bool is_camera(const std::string& input) {
  return input.starts_with("/dev/video");
}

// tcpclientsrc is no source of uridecodebin.
Result<std::string> tcp_source(const TryOptions& options) {
  const std::string& input = options.input;
  const size_t begin = input.find("://") + 3, colon = input.rfind(':');
  const std::string host = input.substr(begin, std::max(colon, begin) - begin);
  const std::string port = input.substr(colon + 1);
  const bool is_port = !port.empty() && port.size() <= 5 &&
                       port.find_first_not_of("0123456789") == std::string::npos;
  if (!host.empty() && colon > begin && is_port)
    return "tcpclientsrc host=" + launch_value(host) + " port=" + port +
           " ! decodebin ! videoconvert";
  return Error{.code = Code::OPTION_VALUE,
               .what = "the address has no host or no port",
               .offered = input,
               .needed = "tcp://HOST:PORT",
               .fix = "weir try " + shell_word(options.model) + " tcp://camera.local:5000"};
}

Result<std::string> source_of(const TryOptions& options) {
  const std::string& input = options.input;
  if (input.starts_with("tcp://")) return tcp_source(options);
  if (input.find("://") != std::string::npos)
    return "uridecodebin uri=" + launch_value(input) + " ! videoconvert";
  std::error_code ignored;
  // A camera does not wait: a model that is slower gets its newest frame.
  if (is_camera(input) && fs::exists(input, ignored))
    return "v4l2src device=" + launch_value(input) +
           " ! decodebin ! videoconvert ! queue leaky=downstream max-size-buffers=1";
  if (fs::is_regular_file(input, ignored)) {
    const std::string file = "filesrc location=" + launch_value(input) + " ! decodebin ! ";
    // A picture of its own has no time.
    return file + (is_photo(input) ? "imagefreeze num-buffers=1 ! videoconvert" : "videoconvert");
  }
  if (input == "test") return std::string("videotestsrc num-buffers=100");
  return Error{
      .code = Code::FILE_NOT_FOUND,
      .what =
          fs::is_directory(input, ignored) ? "the input is a folder" : "the input does not exist",
      .offered = input,
      .needed = "a photo, a video, a camera (/dev/video0), an address (rtsp://...) or test",
      .fix = "weir try " + shell_word(options.model) + " photo.jpg"};
}

Result<std::string> encoder_of(const std::string& output) {
  const std::string extension = extension_of(output),
                    file = "filesink location=" + launch_value(output);
  if (extension == ".jpg" || extension == ".jpeg") return "jpegenc quality=92 ! " + file;
  if (extension == ".png") return "pngenc ! " + file;
  if (extension == ".webm") return "vp8enc deadline=1 cpu-used=8 ! webmmux ! " + file;
  if (extension == ".mkv") return "jpegenc ! matroskamux ! " + file;
  if (extension == ".avi") return "jpegenc ! avimux ! " + file;
  return Error{.code = Code::OPTION_VALUE,
               .what = "the format of the output file is unknown",
               .offered = "--output " + output,
               .needed = "a name that ends in .jpg, .png, .webm, .mkv or .avi",
               .fix = "--output result.jpg for a photo, --output result.webm for a video"};
}

// clocksync keeps to the speed of the video and, other than a sink, shows late frames too. A photo
// stays until its window is closed.
std::string window_for(const std::string& input) {
  return (is_photo(input) ? "imagefreeze ! autovideosink name="
                          : "clocksync ! autovideosink sync=false name=") +
         std::string(kWindow);
}

}  // namespace

bool is_photo(const std::string& path) {
  constexpr const char* kPhotos[] = {".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff"};
  const std::string extension = extension_of(path);
  return std::any_of(std::begin(kPhotos), std::end(kPhotos),
                     [&](const char* known) { return extension == known; });
}

std::string result_elements(const TryModel& model) {
  const std::string labels = model.labels.empty() ? "" : " labels=" + launch_value(model.labels);
  const std::string engine = model.engine.empty() ? "" : " framework=" + launch_value(model.engine);
  return "tensor_preprocess " + model.preparation + " ! tensor_filter" + engine +
         " model=" + launch_value(model.path) + " ! tensor_decoder mode=" + model.mode +
         model.decoder + labels;
}

Result<std::string> try_pipeline(const TryOptions& options, const TryModel& model,
                                 const std::string& text_sink) {
  auto source = source_of(options);
  if (!source) return source;
  const std::string results = result_elements(model);
  // The labels travel with the results.
  const std::string text = "tensor_decoder mode=json ! " + text_sink;
  if (options.output.empty() && !options.show) return *source + " ! " + results + " ! " + text;

  std::string picture = "tensor_overlay name=drawn sync=same-time ! videoconvert ! ";
  if (!options.output.empty()) {
    auto encoder = encoder_of(options.output);
    if (!encoder) return encoder;
    picture += options.show ? "tee name=seen ! queue ! " + *encoder + " seen. ! queue ! " +
                                  window_for(options.input)
                            : *encoder;
  } else {
    picture += window_for(options.input);
  }
  const std::string queue = is_camera(options.input) ? "queue max-size-buffers=1" : "queue";
  return *source + " ! tee name=video ! " + queue + " ! " + picture + " video. ! " + queue + " ! " +
         results + " ! tee name=results ! queue ! drawn.results results. ! queue ! " + text;
}

Status open_window(GstElement* pipeline) {
  const auto window = gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline), kWindow));
  if (!window) return ok();
  const bool is_ready =
      gst_element_set_state(window.get(), GST_STATE_READY) != GST_STATE_CHANGE_FAILURE;
  const auto sink = gst::Ref<GstElement>::adopt(
      GST_ELEMENT(gst_child_proxy_get_child_by_index(GST_CHILD_PROXY(window.get()), 0)));
  GstElementFactory* factory = sink ? gst_element_get_factory(sink.get()) : nullptr;
  if (is_ready && factory && std::string_view(GST_OBJECT_NAME(factory)) != "fakesink") return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "no window can be opened",
               .offered = "--show without a display that a video sink of GStreamer can use",
               .needed = "a graphical session: DISPLAY or WAYLAND_DISPLAY names its display",
               .fix = "--output found.jpg instead of --show, or ssh -X for a remote machine"};
}

}  // namespace weir::app
