// Writes and reads the requests as text and the inputs as bytes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "floor_requests.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace control {
namespace {

constexpr const char* kExtensions[] = {".p", ".r", ".o"};

}  // namespace

std::vector<uint8_t> repeat_bytes(const std::vector<uint8_t>& seen, size_t count) {
  std::vector<uint8_t> out(count, 140);
  for (size_t at = 0; !seen.empty() && at < count; at += seen.size())
    std::copy_n(seen.begin(), std::min(seen.size(), count - at),
                out.begin() + static_cast<ptrdiff_t>(at));
  return out;
}

Seen make_inputs(const Requests& max, uint32_t min_face, const Seen& seen) {
  size_t layers = 0;
  for (const auto& layer : mtcnn::pyramid(max.picture, min_face))
    layers += 3 * size_t{layer.width} * layer.height;
  constexpr size_t kRefine = 3 * mtcnn::kRefineSide * mtcnn::kRefineSide;
  constexpr size_t kMark = 3 * mtcnn::kLandmarkSide * mtcnn::kLandmarkSide;
  return {repeat_bytes(seen[0], layers), repeat_bytes(seen[1], kRefine * max.refined),
          repeat_bytes(seen[2], kMark * max.marked)};
}

std::vector<uint8_t>* RequestFile::wanted(size_t network) {
  return path_.empty() || begun_[network] ? nullptr : &seen_[network];
}

void RequestFile::add(const Requests& requests) {
  if (path_.empty()) return;
  pictures_.push_back(requests);
  for (size_t i = 0; i < seen_.size(); ++i) begun_[i] = !seen_[i].empty();
}

bool RequestFile::write() const {
  if (path_.empty()) return true;
  std::ofstream out(path_);
  for (const Requests& one : pictures_)
    out << one.picture.width << ' ' << one.picture.height << ' ' << one.refined << ' ' << one.marked
        << '\n';
  bool good = static_cast<bool>(out.flush());
  for (size_t i = 0; i < seen_.size(); ++i) {
    std::ofstream bytes(path_ + kExtensions[i], std::ios::binary);
    bytes.write(reinterpret_cast<const char*>(seen_[i].data()),
                static_cast<std::streamsize>(seen_[i].size()));
    good = static_cast<bool>(bytes.flush()) && good;
  }
  return good;
}

std::vector<Requests> read_requests(const std::string& path) {
  std::vector<Requests> out;
  std::ifstream in(path);
  for (Requests one; in >> one.picture.width >> one.picture.height >> one.refined >> one.marked;)
    out.push_back(one);
  return out;
}

Seen read_seen(const std::string& path) {
  Seen out;
  for (size_t i = 0; i < out.size(); ++i) {
    std::ifstream in(path + kExtensions[i], std::ios::binary);
    out[i].assign(std::istreambuf_iterator<char>(in), {});
  }
  return out;
}

}  // namespace control
