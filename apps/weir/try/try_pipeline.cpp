// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/try_pipeline.hpp"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/ref.hpp"
#include "try/photo_direction.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

std::string lower_extension(const std::string& path) {
  return lower(fs::path(path).extension().string());
}

constexpr char kWindow[] = "window";

bool is_camera(const std::string& input) {
  return input.starts_with("/dev/video");
}

// Whether the input goes on while it is not read.
bool is_live(const std::string& input) {
  constexpr const char* kNetworkCameras[] = {"rtsp", "rtmp", "rtp", "udp", "srt", "mms"};
  const size_t colon = input.find("://");
  const std::string scheme = colon == std::string::npos ? "" : lower(input.substr(0, colon));
  return is_camera(input) ||
         std::any_of(std::begin(kNetworkCameras), std::end(kNetworkCameras),
                     [&](const char* begin) { return scheme.starts_with(begin); });
}

// A model that is slower than the input gets its newest frame.
constexpr char kNewest[] = " ! queue leaky=downstream max-size-buffers=1";

// The path of a file:// address; "" for other addresses.
std::string find_local_path(const std::string& uri) {
  const gst::Unique<gchar, g_free> path(g_filename_from_uri(uri.c_str(), nullptr, nullptr));
  return path ? path.get() : "";
}

// A video names its direction in a tag of its stream. A JPEG file may have any name.
std::string turn_upright(const std::string& path) {
  const std::string direction = photo_direction(path);
  return " ! videoconvert ! videoflip video-direction=" + (direction.empty() ? "auto" : direction);
}

// A picture of its own has no time.
std::string convert_photo(const std::string& path) {
  const std::string direction = photo_direction(path);
  return " ! imagefreeze num-buffers=1 ! videoconvert" +
         (direction.empty() ? "" : " ! videoflip video-direction=" + direction);
}

// tcpclientsrc is no source of uridecodebin.
Result<PipelineDescription> tcp_source(const TryOptions& options) {
  const std::string& input = options.input;
  const size_t begin = input.find("://") + 3, colon = input.rfind(':');
  const std::string host = input.substr(begin, std::max(colon, begin) - begin);
  const std::string port = input.substr(colon + 1);
  const bool is_port = !port.empty() && port.size() <= 5 &&
                       port.find_first_not_of("0123456789") == std::string::npos;
  if (!host.empty() && colon > begin && is_port)
    return PipelineDescription()
        .element("tcpclientsrc", {{"host", host}, {"port", port}})
        .text(" ! decodebin ! videoconvert");
  return Error{.code = Code::OPTION_VALUE,
               .what = "the address has no host or no port",
               .offered = input,
               .needed = "tcp://HOST:PORT",
               .fix = "weir try " + shell_word(options.model) + " tcp://camera.local:5000"};
}

Result<PipelineDescription> make_source(const TryOptions& options) {
  const std::string& input = options.input;
  if (input.starts_with("tcp://")) return tcp_source(options);
  if (input.find("://") != std::string::npos)
    return PipelineDescription()
        .element("uridecodebin", {{"uri", input}})
        .text(is_live(input) ? std::string(" ! videoconvert") + kNewest
                             : turn_upright(find_local_path(input)));
  std::error_code ignored;
  if (is_camera(input) && fs::exists(input, ignored))
    return PipelineDescription()
        .element("v4l2src", {{"device", input}})
        .text(" ! decodebin ! videoconvert")
        .text(kNewest);
  if (fs::is_regular_file(input, ignored))
    return PipelineDescription()
        .element("filesrc", {{"location", input}})
        .text(" ! decodebin")
        .text(is_photo(input) ? convert_photo(input) : turn_upright(input));
  if (input == "test") return PipelineDescription().text("videotestsrc num-buffers=100");
  return Error{
      .code = Code::FILE_NOT_FOUND,
      .what =
          fs::is_directory(input, ignored) ? "the input is a folder" : "the input does not exist",
      .offered = input,
      .needed = "a photo, a video, a camera (/dev/video0), an address (rtsp://...) or test",
      .fix = "weir try " + shell_word(options.model) + " photo.jpg"};
}

// Of a video, a picture holds the first frame.
Result<PipelineDescription> make_encoder(const std::string& output, bool is_one_picture) {
  constexpr std::pair<const char*, const char*> kEncoders[] = {
      {".jpg", "jpegenc quality=92"},
      {".jpeg", "jpegenc quality=92"},
      {".png", "pngenc"},
      {".webm", "vp8enc deadline=1 cpu-used=8 ! webmmux"},
      {".mkv", "jpegenc ! matroskamux"},
      {".avi", "jpegenc ! avimux"}};
  for (const auto& [extension, encoder] : kEncoders)
    if (lower_extension(output) == extension)
      return PipelineDescription()
          .text(is_photo(output) && !is_one_picture ? "imagefreeze num-buffers=1 ! " : "")
          .text(std::string(encoder) + " ! ")
          .element("filesink", {{"location", output}});
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
  const std::string extension = lower_extension(path);
  return std::any_of(std::begin(kPhotos), std::end(kPhotos),
                     [&](const char* known) { return extension == known; });
}

PipelineDescription result_elements(const TryModel& model) {
  Properties filter, decoder{{"mode", model.mode}};
  if (!model.engine.empty()) filter.emplace_back("framework", model.engine);
  filter.emplace_back("model", model.path);
  decoder.insert(decoder.end(), model.decoder.begin(), model.decoder.end());
  if (!model.labels.empty()) decoder.emplace_back("labels", model.labels);
  return PipelineDescription()
      .element("tensor_preprocess", model.preparation)
      .text(" ! ")
      .element("tensor_filter", std::move(filter))
      .text(" ! ")
      .element("tensor_decoder", std::move(decoder));
}

Result<PipelineDescription> try_pipeline(const TryOptions& options, const TryModel& model,
                                         const std::string& text_sink) {
  auto out = make_source(options);
  if (!out) return out;
  const auto results = result_elements(model);
  const auto end_with_text = [&] {
    // The labels travel with the results.
    out->element("tensor_decoder", {{"mode", "json"}}).text(" ! " + text_sink);
  };
  if (options.output.empty() && !options.show) {
    out->text(" ! ").append(results).text(" ! ");
    end_with_text();
    return out;
  }
  const std::string queue = is_live(options.input) ? "queue max-size-buffers=1" : "queue";
  out->text(" ! tee name=video ! " + queue +
            " ! tensor_overlay name=drawn sync=same-time ! videoconvert ! ");
  if (!options.output.empty()) {
    const auto encoder = make_encoder(options.output, is_photo(options.input));
    if (!encoder) return encoder.error();
    if (options.show) out->text("tee name=seen ! queue ! ");
    out->append(*encoder);
    if (options.show) out->text(" seen. ! queue ! ");
  }
  if (options.show) out->text(window_for(options.input));
  out->text(" video. ! " + queue + " ! ")
      .append(results)
      .text(" ! tee name=results ! queue ! drawn.results results. ! queue ! ");
  end_with_text();
  return out;
}

Status open_window(GstElement* pipeline) {
  const auto window = gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline), kWindow));
  if (!window) return ok();
  // DirectFB crashes where it finds no framebuffer.
  const auto directfb = gst::Ref<GstPluginFeature>::adopt(
      gst_registry_lookup_feature(gst_registry_get(), "dfbvideosink"));
  if (directfb) gst_plugin_feature_set_rank(directfb.get(), GST_RANK_NONE);
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
