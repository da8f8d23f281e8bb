// Parses with GStreamer's parser. Its error has no position, but its log names the last token read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "launch/pipeline_text.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "core/text/error_text.hpp"
#include "core/text/shell_quote.hpp"
#include "core/text/text.hpp"
#include "gstcpp/element/elements.hpp"
#include "gstcpp/element/property_text.hpp"
#include "launch/launch_graph.hpp"
#include "launch/launch_tokens.hpp"
#include "launch/refused_link.hpp"
#include "machine/install_command.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

constexpr std::string_view kNnstreamer = "NNStreamer", kDlStreamer = "DL Streamer",
                           kDeepStream = "DeepStream", kGStreamer = "GStreamer's analytics",
                           kRos = "ROS";
constexpr std::string_view kDetection =
    "tensor_preprocess ! tensor_filter ! tensor_decoder mode=detection";
constexpr std::string_view kOfRegions =
    "tensor_preprocess with the boxes on its pad regions, tensor_filter, tensor_decoder";
constexpr std::string_view kNode =
    "appsrc or appsink, in a program that is a node, or edgesrc and edgesink between processes";

// In `runs_model`, `weir try MODEL` prints the elements for a model.
struct Foreign {
  std::string_view name, project, equivalent;
  bool runs_model = false;
  bool is_element = false;  // the equivalent can be pasted in its place
};
constexpr std::array kForeign{
    Foreign{"tensor_src_iio", kNnstreamer,
            "appsrc in a program that reads the sensor, with caps other/tensors"},
    Foreign{"tensor_trainer", kNnstreamer,
            "tensor_filter, with a model that was trained elsewhere"},
    Foreign{"tensor_ros_src", kRos, kNode},
    Foreign{"tensor_ros_sink", kRos, kNode},
    Foreign{"gvadetect", kDlStreamer, kDetection, true},
    Foreign{"gvaclassify", kDlStreamer, kOfRegions, true},
    Foreign{"gvainference", kDlStreamer, "tensor_preprocess ! tensor_filter", true},
    Foreign{"gvagenai", kDlStreamer, "tensor_filter framework=oip"},
    Foreign{"gvaaudiodetect", kDlStreamer,
            "audioconvert ! audioresample ! tensor_converter ! tensor_filter"},
    Foreign{"gvatrack", kDlStreamer, "tensor_tracker", false, true},
    Foreign{"gvawatermark", kDlStreamer, "tensor_overlay, with the results on its pad"},
    Foreign{"gvametaconvert", kDlStreamer, "tensor_decoder mode=json", false, true},
    Foreign{"gvametapublish", kDlStreamer, "filesink, mqttsink or another sink"},
    Foreign{"gvametaaggregate", kDlStreamer, "tensor_mux"},
    Foreign{"gvapython", kDlStreamer, "tensor_filter framework=python3 model=SCRIPT.py"},
    Foreign{"gvafpscounter", kDlStreamer, "identity, and the table of weir run"},
    Foreign{"gvaattachroi", kDlStreamer, "boxes on the pad regions of tensor_preprocess"},
    Foreign{"nvinfer", kDeepStream, kDetection, true},
    Foreign{"nvinferserver", kDeepStream, "tensor_filter framework=oip"},
    Foreign{"nvtracker", kDeepStream, "tensor_tracker", false, true},
    Foreign{"nvdsosd", kDeepStream, "tensor_overlay, with the results on its pad"},
    Foreign{"nvdsanalytics", kDeepStream, "tensor_zones"},
    Foreign{"nvmsgconv", kDeepStream, "tensor_decoder mode=json", false, true},
    Foreign{"nvmsgbroker", kDeepStream, "mqttsink"},
    Foreign{"nvstreammux", kDeepStream,
            "a tensor_filter for each stream, with batch-size and the same "
            "shared-tensor-filter-key"},
    Foreign{"nvvideoconvert", kDeepStream, "videoconvert", false, true},
    Foreign{"onnxinference", kGStreamer, kDetection, true},
    Foreign{"tfliteinference", kGStreamer, kDetection, true},
    Foreign{"ssdobjectdetector", kGStreamer, "tensor_decoder mode=detection", false, true},
    Foreign{"ssdtensordec", kGStreamer, "tensor_decoder mode=detection", false, true},
    Foreign{"objectdetectionoverlay", kGStreamer, "tensor_overlay, with the results on its pad"},
};

// The words of the element at `at`, up to what follows it in the text, at `end`.
std::vector<LaunchToken> words_of_element(const std::string& text, size_t at, size_t* end) {
  const auto all = launch_tokens(text);
  std::vector<LaunchToken> out;
  *end = text.size();
  if (!all) return out;
  for (const auto& word : *all) {
    if (word.at < at) continue;
    if (!out.empty() && !word.assigns) {
      *end = word.at;
      break;
    }
    out.push_back(word);
  }
  return out;
}

// A model that `weir try` can open; "" if the words name none.
std::string find_model(const std::vector<LaunchToken>& words) {
  for (const auto& word : words)
    for (const std::string_view key : {"model=", "model-file="})
      for (const std::string_view extension : {".onnx", ".tflite", ".pt", ".caffemodel"})
        if (word.text.starts_with(key) && word.text.ends_with(extension))
          return word.text.substr(key.size());
  return "";
}

// OPTION_SYNTAX with the equivalent of `name`, an element of another project that is at `at` in the
// pipeline `text`. nullopt for other names.
std::optional<Error> foreign_element(const std::string& name, const std::string& text,
                                     std::optional<size_t> at) {
  const auto* known = std::find_if(kForeign.begin(), kForeign.end(),
                                   [&name](const Foreign& one) { return one.name == name; });
  const bool is_ros = name.starts_with("ros") || name.starts_with("tensor_ros");
  const Foreign foreign = known != kForeign.end() ? *known : Foreign{name, kRos, kNode};
  if (known == kForeign.end() && !is_ros) return std::nullopt;
  Error out{.code = Code::OPTION_SYNTAX,
            .what = "Weir has no element " + name + " of " + std::string(foreign.project),
            .needed = std::string(foreign.equivalent)};
  if (foreign.runs_model) out.needed += "; weir try prints them for a model in .onnx or .tflite";
  if (!at) return out;
  size_t end = 0;
  const auto words = words_of_element(text, *at, &end);
  if (foreign.runs_model)
    if (const auto model = find_model(words); !model.empty())
      out.fix = "weir try " + shell_word(model) + " photo.jpg";
  if (!foreign.is_element) return out;
  // Its other properties are left out.
  std::string element(foreign.equivalent);
  for (const auto& word : words)
    if (word.text.starts_with("name=")) element += ' ' + word.text;
  out.fix = text.substr(0, *at) + element + (end < text.size() ? " " : "") + text.substr(end);
  return out;
}

// Elements that a build without an optional library lacks.
struct Optional {
  std::string_view name, needed, fix;
};
constexpr std::string_view kGrpc = install_command("apt-get install gstreamer1.0-weir-net",
                                                   "apt-get install libgrpc++-dev && make install");
constexpr std::string_view kMosquitto = install_command(
    "apt-get install gstreamer1.0-weir-edge", "apt-get install libmosquitto-dev && make install");
constexpr std::string_view kEdge =
    install_command("apt-get install gstreamer1.0-weir-edge", "make install");
constexpr std::array kOptional{
    Optional{"edgesink", "the plug-in weiredge", kEdge},
    Optional{"edgesrc", "the plug-in weiredge", kEdge},
    Optional{"tensor_query_client", "the plug-in weiredge", kEdge},
    Optional{"tensor_query_serversink", "the plug-in weiredge", kEdge},
    Optional{"tensor_query_serversrc", "the plug-in weiredge", kEdge},
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

constexpr std::string_view kFamily = "tensor_";

// Names that begin with "tensor_" are compared by the rest, which tells them apart.
std::string nearest_element(const std::string& name) {
  const bool of_family = name.starts_with(kFamily);
  std::vector<std::string> candidates;
  for (const auto& element : gst::installed_elements())
    if (element.starts_with(kFamily) == of_family)
      candidates.push_back(of_family ? element.substr(kFamily.size()) : element);
  const std::string close = nearest(of_family ? name.substr(kFamily.size()) : name, candidates);
  return of_family && !close.empty() ? std::string(kFamily) + close : close;
}

// Where the element is in the text, other than as part of another word.
std::optional<size_t> find_place(const std::string& name, const std::string& text) {
  const auto tokens = launch_tokens(text);
  if (!tokens) return std::nullopt;
  for (const auto& token : *tokens)
    if (token.text == name) return token.at;
  return std::nullopt;
}

// OPTION_SYNTAX. Says whether `name` belongs to one of Weir's plug-ins, is an element of NNStreamer
// that Weir lacks, or is near the name of an installed element. `text` is the pipeline.
Error missing_element(const std::string& name, const std::string& text) {
  Error out{.code = Code::OPTION_SYNTAX,
            .what = "the element " + name + " is not installed",
            .needed = "an element that gst-inspect-1.0 lists"};
  const auto at = find_place(name, text);
  const std::string place = at ? place_in(text, *at) : "";
  out.difference = place;
  if (auto foreign = foreign_element(name, text, at)) {
    foreign->difference = place;
    return *std::move(foreign);
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

constexpr char kParserCategory[] = "GST_PIPELINE";

std::string text_or_none(const char* text) {
  return text ? text : "";
}

// Returns null or a floating reference. After a syntax error the parser continues and logs a
// critical about its own leftovers, which is suppressed: the error is sufficient.
GstElement* parse_words(const std::vector<std::string>& words, GstParseContext* context,
                        GError** error) {
  const guint quiet = g_log_set_handler(
      "GStreamer", G_LOG_LEVEL_CRITICAL, +[](const char*, GLogLevelFlags, const char*, gpointer) {},
      nullptr);
  std::vector<const char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const auto& word : words) arguments.push_back(word.c_str());
  arguments.push_back(nullptr);
  GstElement* parsed =
      words.size() == 1
          ? gst_parse_launch_full(arguments[0], context, GST_PARSE_FLAG_FATAL_ERRORS, error)
          : gst_parse_launchv_full(arguments.data(), context, GST_PARSE_FLAG_FATAL_ERRORS, error);
  g_log_remove_handler("GStreamer", quiet);
  return parsed;
}

struct Token {
  size_t begin = 0, end = 0;
};

// Tracks the parser's position in the text. Its lexer logs "flex: KIND: TEXT" for each token that
// has a text.
struct Follower {
  const std::string& text;
  std::optional<Token> last = {};
  bool failed = false;

  void handle_message(const std::string& log_text) {
    constexpr std::string_view kLexer = "flex: ";
    failed = failed || log_text.find("syntax error") != std::string::npos;
    const size_t colon = log_text.find(": ", kLexer.size());
    if (failed || !log_text.starts_with(kLexer) || colon == std::string::npos) return;
    const std::string token(strip(std::string_view(log_text).substr(colon + 2)));
    const size_t begin = text.find(token, last ? last->end : 0);
    if (begin != std::string::npos && !log_text.starts_with("flex: SPACE"))
      last = Token{begin, begin + token.size()};
  }
};

void on_log(GstDebugCategory* category, GstDebugLevel, const char*, const char*, gint, GObject*,
            GstDebugMessage* message, gpointer follower) {
  if (g_strcmp0(gst_debug_category_get_name(category), kParserCategory) == 0)
    static_cast<Follower*>(follower)->handle_message(text_or_none(gst_debug_message_get(message)));
}

// The token at which the parser stopped; empty if GStreamer was built without logging.
std::optional<Token> last_token_read(const std::string& text) {
  GstDebugCategory* category = nullptr;
  GST_DEBUG_CATEGORY_GET(category, kParserCategory);
  Follower follower{text};
  const bool to_stderr = (gst_debug_remove_log_function)(gst_debug_log_default) > 0;
  const GstDebugLevel level = gst_debug_category_get_threshold(category);
  (gst_debug_add_log_function)(on_log, &follower, nullptr);
  gst_debug_category_set_threshold(category, GST_LEVEL_DEBUG);
  if (GstElement* parsed = parse_words({text}, nullptr, nullptr))
    gst_object_unref(gst_object_ref_sink(parsed));
  gst_debug_category_set_threshold(category, level);
  gst_debug_remove_log_function_by_data(&follower);
  if (to_stderr) (gst_debug_add_log_function)(gst_debug_log_default, nullptr, nullptr);
  return follower.failed ? follower.last : std::nullopt;
}

// The position in `text` of the first word in double quotes in `message`.
std::optional<Token> quoted_word(const std::string& message, const std::string& text) {
  const auto parts = split(message, "\"", 3);
  if (parts.size() < 3 || parts[1].empty()) return std::nullopt;
  const size_t begin = text.find(parts[1]);
  if (begin == std::string::npos) return std::nullopt;
  return Token{begin, begin + parts[1].size()};
}

// The position in `text` of the word that sets this property.
std::optional<Token> assignment(const gst::RefusedProperty& of, const std::string& text) {
  const auto words = launch_tokens(text);
  if (!words) return std::nullopt;
  const std::string begin = of.property + "=";
  for (const auto& word : *words)
    if (of.value ? word.text == begin + *of.value : word.text.starts_with(begin))
      return Token{word.at, word.at + word.text.size()};
  return std::nullopt;
}

// Adds the text with a caret below the place; this replaces `offered`.
void show_place(const std::string& text, const std::optional<Token>& place, Error* error) {
  if (!place) return;
  if (!error->difference.empty()) error->difference += " ";
  error->difference += place_in(text, place->begin);
  error->offered.clear();
}

// The line with the nearest name or value in place of the rejected one; "" if none is near or the
// line writes it in another way, as with blanks around the =.
std::string with_nearest(const gst::RefusedProperty& refused, const Token& place,
                         const std::string& text) {
  const std::string& rejected = refused.value ? *refused.value : refused.property;
  size_t begin = place.begin + (refused.value ? refused.property.size() + 1 : 0);
  if (begin < text.size() && (text[begin] == '"' || text[begin] == '\'')) ++begin;
  if (refused.nearest.empty() || text.compare(begin, rejected.size(), rejected) != 0) return "";
  return text.substr(0, begin) + refused.nearest + text.substr(begin + rejected.size());
}

Error property_error(gst::RefusedProperty refused, const std::string& text) {
  const auto place = assignment(refused, text);
  show_place(text, place, &refused.error);
  refused.error.offered = refused.property + (refused.value ? "=" + *refused.value : "");
  const std::string mended = place ? with_nearest(refused, *place, text) : "";
  if (!mended.empty()) refused.error.fix = mended;
  return std::move(refused.error);
}

// A closing parenthesis without an opening one, which GStreamer's lexer does not log.
std::optional<Token> lone_parenthesis(const std::string& text) {
  const auto words = launch_tokens(text);
  if (!words) return std::nullopt;
  int open = 0;
  for (const auto& word : *words) {
    if (word.text == "(" || word.text.ends_with(".(")) ++open;
    if (word.text == ")" && --open < 0) return Token{word.at, word.at + 1};
  }
  return std::nullopt;
}

Error syntax_error(const std::string& text, Error out) {
  out.needed = "elements with ! between them, as for gst-launch-1.0";
  const auto parenthesis = lone_parenthesis(text);
  show_place(text, parenthesis ? parenthesis : last_token_read(text), &out);
  return out;
}

Error parse_error(const std::string& text, const GError* error, GstParseContext* context) {
  // GStreamer takes an open quote as part of a value or name.
  if (const auto tokens = launch_tokens(text); !tokens) return tokens.error();
  if (auto refused = error ? gst::refused_property(*error) : std::nullopt)
    return property_error(*std::move(refused), text);
  const auto is = [error](GstParseError kind) {
    return g_error_matches(error, GST_PARSE_ERROR, static_cast<gint>(kind)) != FALSE;
  };
  const gst::Unique<char*, g_strfreev> missing(gst_parse_context_get_missing_elements(context));
  if (is(GST_PARSE_ERROR_NO_SUCH_ELEMENT) && missing && *missing)
    return missing_element(*missing, text);
  if (is(GST_PARSE_ERROR_LINK)) {
    if (auto missing_one = missing_pad(text, nullptr)) return *std::move(missing_one);
    if (auto refused = refused_link(text, text_or_none(error->message))) return *std::move(refused);
  }
  Error out{.code = Code::OPTION_SYNTAX,
            .what = "the pipeline cannot be read",
            .offered = text,
            .difference = error ? text_or_none(error->message) : "GStreamer gives no reason"};
  if (is(GST_PARSE_ERROR_SYNTAX)) return syntax_error(text, std::move(out));
  // GStreamer does not say where a name is that no element has.
  if (const auto graph = read_launch_graph(text); !graph) return graph.error();
  show_place(text, quoted_word(out.difference, text), &out);
  return out;
}

}  // namespace

Result<gst::Ref<GstElement>> read_pipeline(const std::vector<std::string>& words) {
  const std::string text = join(words, " ");
  if (strip(text).empty())
    return Error{.code = Code::OPTION_SYNTAX,
                 .what = "the pipeline is empty",
                 .offered = "\"" + text + "\"",
                 .needed = "elements with ! between them",
                 .fix = "weir run 'videotestsrc num-buffers=30 ! fakesink'"};
  if (auto flags = dimensions_without_type(text)) return *std::move(flags);
  gst::Unique<GstParseContext, gst_parse_context_free> context(gst_parse_context_new());
  GError* error = nullptr;
  GstElement* floating = parse_words(words, context.get(), &error);
  if (floating) gst_object_ref_sink(floating);
  auto parsed = gst::Ref<GstElement>::adopt(floating);
  if (!parsed || error) {
    auto failure = parse_error(text, error, context.get());
    g_clear_error(&error);
    return failure;
  }
  if (auto missing = missing_pad(text, parsed.get())) return *std::move(missing);
  if (auto missing = missing_link(text)) return *std::move(missing);
  if (GST_IS_PIPELINE(parsed.get())) return parsed;
  auto pipeline =
      gst::Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new(nullptr))));
  gst_bin_add(GST_BIN(pipeline.get()), parsed.get());
  return pipeline;
}

}  // namespace weir::app
