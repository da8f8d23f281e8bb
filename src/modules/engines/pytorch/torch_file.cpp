// The directory of a zip archive.
#include "pytorch/torch_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace weir::engine {
namespace {

// torch.save() before version 1.6: a pickle of protocol 2 that begins with this long integer.
constexpr unsigned char kOldPickle[] = {0x80, 0x02, 0x8a, 0x0a, 0x6c, 0xfc, 0x9c,
                                        0x46, 0xf9, 0x20, 0x6a, 0xa8, 0x50, 0x19};
constexpr uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50;
constexpr uint32_t kEnd64 = 0x06064b50, kEnd64Locator = 0x07064b50;
constexpr size_t kEndBytes = 22, kLocatorBytes = 20, kEnd64Bytes = 56, kCentralBytes = 46,
                 kLocalBytes = 30;

const char* const kSaveAsScript =
    "torch.jit.script(model).save(\"model.pt\"), or torch.jit.trace(model, example).save(...), in "
    "Python";

Error invalid(const std::string& offered) {
  return Error{Code::MODEL_INVALID,
               "the file is truncated, damaged or not a TorchScript model",
               offered,
               "a complete TorchScript archive",
               "",
               kSaveAsScript};
}

Error python_only(const std::string& offered) {
  return Error{Code::MODEL_UNSUPPORTED,
               "the file holds no program that can be run, only what Python needs beside one",
               offered,
               "a TorchScript archive, which holds code and weights",
               "",
               kSaveAsScript};
}

class Bytes {
 public:
  explicit Bytes(std::span<const std::byte> bytes) : bytes_(bytes) {}
  size_t size() const noexcept { return bytes_.size(); }
  bool has(uint64_t at, uint64_t count) const noexcept {
    return at <= bytes_.size() && count <= bytes_.size() - at;
  }
  // Little-endian. Precondition: has(at, sizeof(T)).
  template <class T>
  T number(uint64_t at) const noexcept {
    T out = 0;
    std::memcpy(&out, bytes_.data() + at, sizeof out);
    return out;
  }
  std::span<const std::byte> part(uint64_t at, uint64_t count) const noexcept {
    return bytes_.subspan(at, count);
  }
  std::string_view text(uint64_t at, size_t count) const noexcept {
    return {reinterpret_cast<const char*>(bytes_.data()) + at, count};
  }

 private:
  std::span<const std::byte> bytes_;
};

struct Directory {
  uint64_t entries = 0, at = 0;
};

// The record at the end, behind which there may be a comment of up to 64 KiB.
std::optional<Directory> find_directory(const Bytes& file) {
  if (file.size() < kEndBytes) return std::nullopt;
  const size_t last = file.size() - kEndBytes;
  for (size_t back = 0; back <= std::min<size_t>(last, 0xFFFF); ++back) {
    const size_t at = last - back;
    if (file.number<uint32_t>(at) != kEnd) continue;
    Directory out{file.number<uint16_t>(at + 10), file.number<uint32_t>(at + 16)};
    if (at < kLocatorBytes || file.number<uint32_t>(at - kLocatorBytes) != kEnd64Locator)
      return out;
    const auto end64 = file.number<uint64_t>(at - kLocatorBytes + 8);
    if (!file.has(end64, kEnd64Bytes) || file.number<uint32_t>(end64) != kEnd64) return out;
    return Directory{file.number<uint64_t>(end64 + 32), file.number<uint64_t>(end64 + 48)};
  }
  return std::nullopt;
}

struct Contents {
  bool code = false, data = false, constants = false;
  std::vector<CompressedEntry> compressed;
};

// "name/data.pkl" -> "data.pkl": every entry lies in a folder that bears the model's name.
std::string_view inside(std::string_view name) {
  const size_t slash = name.find('/');
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

// One entry, whose place in the directory and whose beginning are within the file.
Status check_entry(const Bytes& file, uint64_t at, uint64_t local, const std::string& name,
                   Contents* out) {
  const auto method = file.number<uint16_t>(at + 10);
  const auto crc = file.number<uint32_t>(at + 16);
  const uint64_t packed = file.number<uint32_t>(at + 20), bytes = file.number<uint32_t>(at + 24);
  const uint64_t begin =
      local + kLocalBytes + file.number<uint16_t>(local + 26) + file.number<uint16_t>(local + 28);
  if (!file.has(begin, packed)) return invalid(name + " does not lie within the archive");
  if (method == 8) {
    out->compressed.push_back({name, crc});
    return ok();
  }
  if (method != 0 || packed != bytes) return invalid(name + " is packed in no known way");
  return crc32(file.part(begin, bytes)) == crc ? ok() : invalid(name + " has another checksum");
}

Result<Contents> read_directory(const Bytes& file, const Directory& directory) {
  Contents out;
  uint64_t at = directory.at;
  for (uint64_t i = 0; i < directory.entries; ++i) {
    if (!file.has(at, kCentralBytes) || file.number<uint32_t>(at) != kCentral)
      return invalid("entry " + std::to_string(i) + " of the archive is not where it should be");
    const auto name_bytes = file.number<uint16_t>(at + 28);
    const uint64_t rest =
        uint64_t{name_bytes} + file.number<uint16_t>(at + 30) + file.number<uint16_t>(at + 32);
    if (!file.has(at + kCentralBytes, rest)) return invalid("the archive's directory is cut");
    const auto name = file.text(at + kCentralBytes, name_bytes);
    const uint64_t bytes = file.number<uint32_t>(at + 20), local = file.number<uint32_t>(at + 42);
    const bool long_numbers = bytes == UINT32_MAX || local == UINT32_MAX;
    if (!long_numbers &&
        (!file.has(local, kLocalBytes + bytes) || file.number<uint32_t>(local) != kLocal))
      return invalid(std::string(name) + " does not lie within the archive");
    const auto part = inside(name);
    if (!long_numbers)
      if (auto status = check_entry(file, at, local, std::string(part), &out); !status)
        return status.error();
    out.code = out.code || part.starts_with("code/");
    out.data = out.data || part == "data.pkl";
    out.constants = out.constants || part == "constants.pkl";
    at += kCentralBytes + rest;
  }
  return out;
}

bool begins_with(std::span<const unsigned char> head, std::span<const unsigned char> magic) {
  return head.size() >= magic.size() && std::equal(magic.begin(), magic.end(), head.begin());
}

}  // namespace

int torch_score(std::span<const unsigned char> head) noexcept {
  if (begins_with(head, kOldPickle)) return 60;
  if (head.size() < kLocalBytes || std::memcmp(head.data(), "PK\3\4", 4) != 0) return 0;
  const size_t name_bytes = head[26] | head[27] << 8;
  const std::string_view name(reinterpret_cast<const char*>(head.data()) + kLocalBytes,
                              std::min(name_bytes, head.size() - kLocalBytes));
  const auto part = inside(name);
  return part == "data.pkl" || part == "version" || part == "constants.pkl" ||
                 part.starts_with("data/") || part.starts_with("code/")
             ? 90
             : 10;
}

uint32_t crc32(std::span<const std::byte> bytes) noexcept {
  static const auto table = [] {
    std::array<uint32_t, 256> out{};
    for (uint32_t i = 0; i < out.size(); ++i) {
      out[i] = i;
      for (int bit = 0; bit < 8; ++bit) out[i] = out[i] >> 1 ^ (out[i] & 1 ? 0xEDB88320u : 0);
    }
    return out;
  }();
  uint32_t crc = ~0u;
  for (const std::byte byte : bytes)
    crc = crc >> 8 ^ table[(crc ^ static_cast<uint8_t>(byte)) & 0xFF];
  return ~crc;
}

Result<std::vector<CompressedEntry>> check_torch_file(std::span<const std::byte> file) {
  const std::span head(reinterpret_cast<const unsigned char*>(file.data()), file.size());
  if (begins_with(head, kOldPickle))
    return python_only("a state dict or Python object, as torch.save() wrote it before 1.6");
  if (file.size() < 4 || std::memcmp(file.data(), "PK\3\4", 4) != 0)
    return invalid("no zip archive");
  const Bytes bytes(file);
  const auto directory = find_directory(bytes);
  if (!directory) return invalid("a zip archive that was cut: its directory is missing");
  auto contents = read_directory(bytes, *directory);
  if (!contents) return contents.error();
  if (contents->code && contents->data && contents->constants) return contents->compressed;
  if (contents->data)
    return python_only("a state dict or Python object, as torch.save() writes it");
  return invalid("a zip archive without data.pkl and code");
}

}  // namespace weir::engine
