// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tflite-file/tflite_metadata.hpp"

#include <charconv>
#include <cstdint>
#include <cstring>
#include <vector>

#include "tflite-file/flat_buffer.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

constexpr size_t kLabelBytesLimit = size_t{1} << 20;
constexpr uint8_t kImageProperties = 2, kNormalization = 1;
constexpr int8_t kRgb = 1, kGrayscale = 2, kAxisLabels = 2;

std::string numbers(const FlatVector& values) {
  std::vector<std::string> out;
  for (uint32_t i = 0; i < values.size() && i < 16; ++i) {
    char text[32];
    out.emplace_back(text, std::to_chars(text, text + sizeof text, values.scalar<float>(i)).ptr);
  }
  return join(out, ",");
}

void read_input(const FlatTable& input, std::map<std::string, std::string>* out) {
  const FlatTable content = input.table(3);
  if (content.scalar<uint8_t>(0, 0) != kImageProperties) return;
  const auto color = content.table(1).scalar<int8_t>(0, 0);
  if (color == kRgb) (*out)["tflite.color_space"] = "RGB";
  if (color == kGrayscale) (*out)["tflite.color_space"] = "GRAYSCALE";
  const FlatVector units = input.vector(4, 4);
  for (uint32_t i = 0; i < units.size(); ++i) {
    const FlatTable unit = units.table(i);
    if (unit.scalar<uint8_t>(0, 0) != kNormalization) continue;
    (*out)["tflite.mean"] = numbers(unit.table(1).vector(0, 4));
    (*out)["tflite.std"] = numbers(unit.table(1).vector(1, 4));
  }
}

std::string find_label_file(const FlatTable& output) {
  const FlatVector files = output.vector(6, 4);
  for (uint32_t i = 0; i < files.size(); ++i) {
    const FlatTable file = files.table(i);
    if (file.scalar<int8_t>(2, 0) == kAxisLabels) return std::string(file.string(0).text());
  }
  return "";
}

// Reads little-endian numbers of the archive; 0 outside the bytes.
class Archive {
 public:
  explicit Archive(std::span<const std::byte> bytes) : bytes_(bytes) {}

  // The content of the stored entry with this name; empty when there is none.
  std::string entry(std::string_view name) const {
    constexpr uint32_t kEntry = 0x02014b50, kEnd = 0x06054b50;
    constexpr size_t kEndBytes = 22, kCommentLimit = 65535;
    if (bytes_.size() < kEndBytes) return "";
    size_t end = bytes_.size() - kEndBytes;
    const size_t last = end > kCommentLimit ? end - kCommentLimit : 0;
    while (read<uint32_t>(end) != kEnd)
      if (end-- == last) return "";
    // Offsets count from the start of the archive, which follows the model or is the start of the
    // file.
    const uint64_t directory_bytes = read<uint32_t>(end + 12), directory = read<uint32_t>(end + 16);
    if (directory_bytes > end || directory > end - directory_bytes) return "";
    const uint64_t begin = end - directory_bytes - directory;
    uint64_t at = begin + directory;
    for (uint16_t left = read<uint16_t>(end + 10); left > 0 && read<uint32_t>(at) == kEntry;
         --left) {
      const uint16_t name_bytes = read<uint16_t>(at + 28);
      if (text(at + 46, name_bytes) == name) return content(at, begin);
      at += 46u + name_bytes + read<uint16_t>(at + 30) + read<uint16_t>(at + 32);
    }
    return "";
  }

 private:
  std::string content(uint64_t entry, uint64_t begin) const {
    const bool stored = read<uint16_t>(entry + 10) == 0;
    const uint64_t size = read<uint32_t>(entry + 24), local = begin + read<uint32_t>(entry + 42);
    if (!stored || size > kLabelBytesLimit) return "";
    const uint64_t data = local + 30 + read<uint16_t>(local + 26) + read<uint16_t>(local + 28);
    return std::string(text(data, size));
  }
  template <class T>
  T read(uint64_t at) const {
    T value{};
    if (at <= bytes_.size() && bytes_.size() - at >= sizeof value)
      std::memcpy(&value, bytes_.data() + at, sizeof value);
    return value;
  }
  std::string_view text(uint64_t at, uint64_t size) const {
    if (at > bytes_.size() || size > bytes_.size() - at) return {};
    return {reinterpret_cast<const char*>(bytes_.data()) + at, static_cast<size_t>(size)};
  }

  std::span<const std::byte> bytes_;
};

}  // namespace

std::map<std::string, std::string> tflite_properties(std::span<const std::byte> file,
                                                     std::span<const std::byte> metadata) {
  std::map<std::string, std::string> out;
  FlatFile flat(metadata);
  const FlatVector graphs = flat.root().vector(3, 4);
  if (graphs.size() == 0) return {};
  const FlatTable graph = graphs.table(0);
  const FlatVector inputs = graph.vector(2, 4), outputs = graph.vector(3, 4);
  if (inputs.size() > 0) read_input(inputs.table(0), &out);
  const std::string labels = outputs.size() > 0 ? find_label_file(outputs.table(0)) : "";
  if (flat.damaged()) return {};
  if (!labels.empty())
    if (const std::string content = Archive(file).entry(labels); !content.empty())
      out["tflite.labels"] = content;
  return out;
}

}  // namespace weir::engine
