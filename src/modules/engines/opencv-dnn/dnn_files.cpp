// Identifies the files of a network by their extensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_files.hpp"

#include <filesystem>
#include <vector>

#include "model_bytes.hpp"
#include "protobuf_reader.hpp"
#include "weir/engine_tools.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

namespace fs = std::filesystem;

bool ends_in(const std::string& path, const std::string& suffix) {
  return equals_ignoring_case(fs::path(path).extension().string(), "." + suffix);
}

Error wrong_files(const std::string& offered) {
  const std::string weights = dnn_engine.weights_extension, text = dnn_engine.description_extension;
  const bool one = dnn_engine.format == DnnFormat::Tensorflow;
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string("the engine ") + dnn_engine.name + " needs different files",
               .offered = offered,
               .needed = one ? "a frozen graph (.pb), and a .pbtxt if OpenCV needs one"
                             : "one ." + text + " and one ." + weights,
               .fix = one ? "model=graph.pb" : "model=net." + text + ",net." + weights};
}

Status check_graph_head(std::span<const std::byte> head) {
  return can_begin_message(head) ? ok() : Status(describe_tensorflow(head).error());
}
Status check_caffe_head(std::span<const std::byte> head) {
  return can_begin_message(head) ? ok() : check_caffe_weights(head);
}

// The check of the first bytes of the weights; null when the format has none.
decltype(ModelLimits::check_head) weights_head() {
  if (dnn_engine.format == DnnFormat::Tensorflow) return check_graph_head;
  return dnn_engine.format == DnnFormat::Caffe ? check_caffe_head : nullptr;
}

Result<std::vector<std::byte>> bytes_of(const std::string& path, const ModelLimits& limits = {}) {
  const char* paths[] = {path.c_str()};
  weir_open one{};
  one.struct_size = sizeof one;
  one.n_models = 1;
  one.paths = paths;
  auto file = read_model(one, limits);
  if (!file) return file.error();
  return std::move(file->owned);
}

struct Paths {
  std::string description, weights;
};

// Adds the file that is not given: it has the name of the other one. `all` is for errors.
Result<Paths> with_other(Paths paths, const std::string& all) {
  const bool has_weights = !paths.weights.empty();
  fs::path beside = has_weights ? paths.weights : paths.description;
  beside.replace_extension(has_weights ? dnn_engine.description_extension
                                       : dnn_engine.weights_extension);
  std::error_code ignored;
  if (!fs::is_regular_file(beside, ignored))
    return wrong_files(all + "; " + beside.string() + " is not there");
  (has_weights ? paths.description : paths.weights) = beside.string();
  return paths;
}

Result<Paths> paths_of(const weir_open& request) {
  Paths out;
  std::vector<std::string> given;
  for (uint32_t i = 0; request.paths && i < request.n_models; ++i)
    if (request.paths[i] && *request.paths[i]) given.emplace_back(request.paths[i]);
  if (given.empty()) return wrong_files("no file");
  const std::string all = join(given, ", ");
  for (const auto& path : given) {
    const bool description = ends_in(path, dnn_engine.description_extension);
    std::string& place = description ? out.description : out.weights;
    if (!place.empty()) return wrong_files(all);
    place = path;
  }
  if (dnn_engine.format == DnnFormat::Tensorflow)
    return out.weights.empty() ? Result<Paths>(wrong_files(all)) : out;
  return out.description.empty() || out.weights.empty() ? with_other(std::move(out), all) : out;
}

Result<DnnDescription> described(const DnnFiles& files) {
  const std::string_view text(reinterpret_cast<const char*>(files.description.data()),
                              files.description.size());
  const std::span<const std::byte> weights(files.weights);
  if (files.format == DnnFormat::Tensorflow) return describe_tensorflow(weights);
  if (files.format == DnnFormat::Darknet) return describe_darknet(text);
  auto out = describe_caffe(text);
  if (!out) return out;
  if (auto status = check_caffe_weights(weights); !status) return status.error();
  return out;
}

}  // namespace

Result<DnnSource> read_dnn_files(const weir_open& request) {
  const auto paths = paths_of(request);
  if (!paths) return paths.error();
  DnnSource out;
  out.files.format = dnn_engine.format;
  out.files.name = paths->weights;
  auto weights = bytes_of(paths->weights, {.check_head = weights_head()});
  if (!weights) return weights.error();
  out.files.weights = *std::move(weights);
  if (!paths->description.empty()) {
    auto description = bytes_of(paths->description);
    if (!description) return description.error();
    out.files.description = *std::move(description);
  }
  auto description = described(out.files);
  if (!description) {
    Error error = description.error();
    const auto& file =
        error.what.find("description") != std::string::npos ? paths->description : paths->weights;
    error.offered = file + (error.offered.empty() ? "" : ": " + error.offered);
    return error;
  }
  out.description = *std::move(description);
  return out;
}

}  // namespace weir::engine
