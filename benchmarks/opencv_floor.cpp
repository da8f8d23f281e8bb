// OpenCV's DNN module in a plain loop.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <opencv2/dnn.hpp>

#include "engine_floor.hpp"

namespace weir::bench {
namespace {

class OpencvFloor : public EngineFloor {
 public:
  OpencvFloor(const std::string& models, const std::vector<int64_t>& shape) {
    cv::setNumThreads(1);
    const size_t comma = models.find(',');
    net_ = comma == std::string::npos
               ? cv::dnn::readNetFromTensorflow(models)
               : cv::dnn::readNetFromCaffe(models.substr(0, comma), models.substr(comma + 1));
    names_ = net_.getUnconnectedOutLayersNames();
    const std::vector<int> extents(shape.begin(), shape.end());
    input_ = cv::Mat::zeros(static_cast<int>(extents.size()), extents.data(), CV_32F);
  }
  void run(int frames) override {
    for (int i = 0; i < frames; ++i) {
      net_.setInput(input_);
      std::vector<cv::Mat> outputs;
      net_.forward(outputs, names_);
    }
  }

 private:
  cv::dnn::Net net_;
  std::vector<cv::String> names_;
  cv::Mat input_;
};

}  // namespace

std::unique_ptr<EngineFloor> make_floor(const std::string& models,
                                        const std::vector<int64_t>& shape, bool) {
  return std::make_unique<OpencvFloor>(models, shape);
}

}  // namespace weir::bench
