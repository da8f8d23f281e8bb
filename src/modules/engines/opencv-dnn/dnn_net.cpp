// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_net.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>
#include <opencv2/dnn.hpp>
#include <optional>

#include "opencv-dnn/opencv_process.hpp"
#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

std::string first_line(const std::string& text) {
  const size_t start = text.find_first_not_of(" \n");
  if (start == std::string::npos) return {};
  return text.substr(start, std::min(text.find('\n', start), text.size()) - start);
}

std::string get_reason(const cv::Exception& e) {
  std::string out = first_line(e.err);
  if (e.code == cv::Error::StsAssert) out = "condition not met: " + out;
  return e.func.empty() ? out : out + " (in " + e.func + ")";
}

template <class Body, class Say>
auto caught(Body&& body, Say&& say) -> decltype(body()) {
  try {
    return body();
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return say(get_reason(e));
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return say(first_line(e.what()));
  }
}

std::optional<int> to_opencv(uint32_t type) {
  switch (type) {
    case WEIR_UINT8:
      return CV_8U;
    case WEIR_INT8:
      return CV_8S;
    case WEIR_UINT16:
      return CV_16U;
    case WEIR_INT16:
      return CV_16S;
    case WEIR_INT32:
      return CV_32S;
    case WEIR_FLOAT16:
      return CV_16F;
    case WEIR_FLOAT32:
      return CV_32F;
    case WEIR_FLOAT64:
      return CV_64F;
    default:
      return std::nullopt;
  }
}

std::optional<uint32_t> from_opencv(int depth) {
  for (uint32_t type = 0; type < WEIR_TYPE_END; ++type)
    if (to_opencv(type) == depth) return type;
  return std::nullopt;
}

// Permutes axes to 0, 3, 1, 2 (NHWC to NCHW) or, without `to_planes`, to 0, 2, 3, 1.
void permute(const float* from, const int* extents, bool to_planes, float* to) {
  const int batch = extents[0];
  const size_t rows = static_cast<size_t>(to_planes ? extents[1] * extents[2] : extents[1]);
  const size_t columns = static_cast<size_t>(to_planes ? extents[3] : extents[2] * extents[3]);
  for (int b = 0; b < batch; ++b, from += rows * columns, to += rows * columns)
    for (size_t r = 0; r < rows; ++r)
      for (size_t c = 0; c < columns; ++c) to[c * rows + r] = from[r * columns + c];
}

Result<cv::Mat> to_mat(const DnnInput& input) {
  const auto type = to_opencv(input.info.type);
  const auto bytes = tensor_bytes(input.info);
  if (!type || !bytes || *bytes > INT32_MAX)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "OpenCV does not accept an input of this type or size",
                 .offered = describe(input.info),
                 .needed = "float32, or 8 to 64 bits converted to float32; less than 2 GiB",
                 .fix = "tensor_transform mode=typecast option=float32 ! tensor_filter"};
  std::vector<int> extents(input.info.shape, input.info.shape + input.info.rank);
  if (extents.empty()) extents = {1};
  cv::Mat mat(static_cast<int>(extents.size()), extents.data(), *type,
              const_cast<void*>(input.data));  // read only: setInput copies it
  if (*type != CV_32F) {
    cv::Mat floats;
    mat.convertTo(floats, CV_32F);
    mat = floats;
  }
  if (!input.nhwc || extents.size() != 4) return mat;
  const int planes[]{extents[0], extents[3], extents[1], extents[2]};
  cv::Mat out(4, planes, CV_32F);
  permute(mat.ptr<float>(), extents.data(), true, out.ptr<float>());
  return out;
}

// OpenCV has no error code for this, only messages.
bool is_missing_feature(const std::string& reason) {
  for (const char* phrase :
       {"an't create layer", "nknown layer type", "ot implemented", "ot supported",
        "nsupported"})  // the first letter may be upper or lower case
    if (reason.find(phrase) != std::string::npos) return true;
  return false;
}

Error load_error(const std::string& model, const std::string& reason) {
  Error error{.code = Code::MODEL_INVALID,
              .what = "OpenCV cannot load the network",
              .offered = model + ": " + reason,
              .fix = "download the files again; both must belong to the same network"};
  if (!is_missing_feature(reason)) return error;
  error.code = Code::MODEL_UNSUPPORTED;
  error.what = "the network has a layer that OpenCV lacks";
  error.fix = "export the network to ONNX or TensorFlow Lite, whose engines support more layers";
  return error;
}

// The result in one piece; a picture permuted to NHWC.
cv::Mat dense(const cv::Mat& result, bool is_picture) {
  cv::Mat mat = result.isContinuous() ? result : result.clone();
  if (!is_picture || mat.dims != 4 || mat.depth() != CV_32F) return mat;
  const int extents[]{mat.size[0], mat.size[2], mat.size[3], mat.size[1]};
  cv::Mat turned(4, extents, CV_32F);
  permute(mat.ptr<float>(), mat.size.p, false, turned.ptr<float>());
  return turned;
}

}  // namespace

struct DnnNet::Parts {
  cv::dnn::Net net;
  std::vector<cv::Mat> results, turned;

  static const char* text(const std::vector<std::byte>& bytes) {
    return reinterpret_cast<const char*>(bytes.data());
  }
  cv::dnn::Net load(const DnnFiles& files) {
    switch (files.format) {
      case DnnFormat::Caffe:
        return cv::dnn::readNetFromCaffe(text(files.description), files.description.size(),
                                         text(files.weights), files.weights.size());
      case DnnFormat::Tensorflow:
        return cv::dnn::readNetFromTensorflow(text(files.weights), files.weights.size(),
                                              text(files.description), files.description.size());
      default:
        return cv::dnn::readNetFromDarknet(text(files.description), files.description.size(),
                                           text(files.weights), files.weights.size());
    }
  }
  // The bytes of weights that the Darknet layers read. For a shorter file OpenCV leaves the rest of
  // the weights uninitialised.
  size_t darknet_bytes() {
    size_t values = 0;
    for (const auto& name : net.getLayerNames()) {
      const auto layer = net.getLayer(net.getLayerId(name));
      if (layer->type == "Convolution" || layer->type == "BatchNorm" ||
          layer->type == "InnerProduct")
        for (const auto& blob : layer->blobs) values += blob.total();
    }
    return values * sizeof(float);
  }
  // Returns the first layer that fails on the current inputs, "" when none does.
  std::string culprit() {
    for (const auto& name : net.getLayerNames()) try {
        net.forward(name);
      } catch (const std::exception&) {
        return "layer " + name + " (" + net.getLayer(net.getLayerId(name))->type + ")";
      }
    return {};
  }
};

DnnNet::DnnNet(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DnnNet::~DnnNet() = default;

Result<std::unique_ptr<DnnNet>> DnnNet::read(const DnnFiles& files, int threads) {
  using Read = Result<std::unique_ptr<DnnNet>>;
  const OpenCvQuiet quiet;
  return caught(
      [&]() -> Read {
        const OpenCvThreads use(threads);
        auto parts = std::make_unique<Parts>();
        parts->net = parts->load(files);
        if (parts->net.empty()) return load_error(files.name, "it contains no layer");
        parts->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
        parts->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
        // getLayer() creates a layer, so this fails now for layers that OpenCV lacks.
        for (const auto& name : parts->net.getLayerNames())
          parts->net.getLayer(parts->net.getLayerId(name));
        constexpr size_t kShortHead = 16;
        const size_t needed = kShortHead + parts->darknet_bytes();
        if (files.format == DnnFormat::Darknet && files.weights.size() < needed)
          return load_error(files.name, "it ends at least " +
                                            std::to_string(needed - files.weights.size()) +
                                            " bytes too early");
        return std::unique_ptr<DnnNet>(new DnnNet(std::move(parts)));
      },
      [&](const std::string& reason) -> Read { return load_error(files.name, reason); });
}

std::vector<std::string> DnnNet::layers() const {
  return parts_->net.getLayerNames();
}

std::vector<std::string> DnnNet::ends() const {
  return parts_->net.getUnconnectedOutLayersNames();
}

Result<std::vector<DnnOutput>> DnnNet::run(std::span<const DnnInput> inputs,
                                           std::span<const std::string> outputs,
                                           std::span<const bool> pictures, int threads) {
  using Outputs = Result<std::vector<DnnOutput>>;
  const OpenCvQuiet quiet;
  return caught(
      [&]() -> Outputs {
        const OpenCvThreads use(threads);
        for (const auto& input : inputs) {
          auto mat = to_mat(input);
          if (!mat) return mat.error();
          parts_->net.setInput(*mat, input.name);
        }
        auto& results = parts_->results;
        results.clear();
        parts_->net.forward(results, std::vector<cv::String>(outputs.begin(), outputs.end()));
        parts_->turned.assign(results.size(), {});
        std::vector<DnnOutput> out(results.size());
        for (size_t i = 0; i < results.size(); ++i) {
          const cv::Mat mat = dense(results[i], i < pictures.size() && pictures[i]);
          parts_->turned[i] = mat;  // keeps the memory alive
          const auto type = from_opencv(mat.depth());
          if (!type || mat.dims > WEIR_RANK_LIMIT)
            return unsupported_type("an output", outputs[i], "", "numbers, rank 16 at most");
          out[i].info = open_tensor_info();
          out[i].info.type = *type;
          set_shape(&out[i].info, mat.size.p, static_cast<size_t>(mat.dims));
          out[i].data = mat.data;
        }
        return out;
      },
      [&](const std::string& reason) -> Outputs {
        const OpenCvQuiet quiet;
        return Error{.code = Code::INVOKE_FAILED,
                     .what = "OpenCV failed on a frame",
                     .offered = reason,
                     .difference = parts_->culprit()};
      });
}

int DnnNet::threads() {
  return OpenCvThreads::now();
}

std::string DnnNet::version() {
  return cv::getVersionString();
}

std::string DnnNet::path() {
  Dl_info info{};
  return dladdr(reinterpret_cast<const void*>(&cv::getVersionString), &info) && info.dli_fname
             ? info.dli_fname
             : "";
}

}  // namespace weir::engine
