// An engine for tests that answers every frame with the outputs that its model file holds, so that
// a pipeline with tensor_preprocess and tensor_decoder reads known tensors as those of a network.
//
// The file, which tests/heads/recording.py writes, has lines of words and then the bytes of the
// outputs, one after the other:
//   input TYPE EXTENT,...                        extents outermost first; TYPE is a weir_type
//   output TYPE EXTENT,... SCALE ZERO_POINT NAME  "-" = no name
//   metadata JSON
//   end
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>
#include <deque>
#include <fstream>
#include <sstream>
#include <vector>

#include "weir/engine.hpp"

namespace {

[[noreturn]] void fail(const std::string& what, const std::string& offered) {
  throw weir::Failure({.code = weir::Code::MODEL_INVALID,
                       .what = what,
                       .offered = offered,
                       .needed = "a file that tests/heads/recording.py wrote"});
}

class Recorded {
 public:
  explicit Recorded(const weir::OpenRequest& request) {
    std::ifstream file(request.paths.front(), std::ios::binary);
    std::string line;
    while (std::getline(file, line) && line != "end") read_line(line);
    if (!file || outputs_.empty()) fail("the recording has no outputs", request.paths.front());
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
  }
  std::span<const weir_tensor_info> inputs() const { return inputs_; }
  std::span<const weir_tensor_info> outputs() const { return outputs_; }
  void describe(weir_model_info& info) const {
    if (!metadata_.empty()) info.metadata_json = metadata_.c_str();
  }
  bool invoke(std::span<const weir_tensor>, std::span<weir_tensor> out) {
    size_t at = 0;
    for (weir_tensor& tensor : out) {
      if (tensor.bytes > bytes_.size() - at)
        fail("the recording is too short", std::to_string(bytes_.size()) + " bytes");
      std::memcpy(tensor.data, bytes_.data() + at, tensor.bytes);
      at += tensor.bytes;
    }
    return true;
  }

 private:
  void read_line(const std::string& line) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "metadata") {
      std::getline(words >> std::ws, metadata_);
      return;
    }
    weir_tensor_info info{};
    int type = 0;
    std::string extents, extent, name;
    words >> type >> extents;
    info.type = static_cast<weir_type>(type);
    info.batch_axis = WEIR_NO_BATCH_AXIS;
    std::istringstream list(extents);
    while (std::getline(list, extent, ',') && info.rank < WEIR_RANK_LIMIT)
      info.shape[info.rank++] = std::stol(extent);
    if (kind == "output") words >> info.scale >> info.zero_point >> name;
    if (!words || (kind != "input" && kind != "output")) fail("a line cannot be read", line);
    if (!name.empty() && name != "-") info.name = names_.emplace_back(name).c_str();
    (kind == "input" ? inputs_ : outputs_).push_back(info);
  }

  std::deque<std::string> names_;  // stay where they are
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::vector<char> bytes_;
  std::string metadata_;
};

}  // namespace

WEIR_ENGINE(Recorded, "recorded", "1", "", "recorded")
