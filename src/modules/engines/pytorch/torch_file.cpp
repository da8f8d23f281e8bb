// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torch_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace weir::engine {
namespace {

// torch.save() before version 1.6: a protocol 2 pickle that begins with this long integer.
constexpr unsigned char kOldPickle[] = {0x80, 0x02, 0x8a, 0x0a, 0x6c, 0xfc, 0x9c,
                                        0x46, 0xf9, 0x20, 0x6a, 0xa8, 0x50, 0x19};
constexpr uint32_t kLocal = 0x04034b50, kCentral = 0x02014b50, kEnd = 0x06054b50;
constexpr uint32_t kEnd64 = 0x06064b50, kEnd64Locator = 0x07064b50;
constexpr size_t kEndBytes = 22, kLocatorBytes = 20, kEnd64Bytes = 56, kCentralBytes = 46,
                 kLocalBytes = 30;
constexpr uint64_t kMaxDeflated = 1032;  // the most bytes to which one byte of DEFLATE can expand
constexpr uint64_t kPieceBytes = 1 << 20;

const char* const kSaveAsScript =
    "torch.jit.script(model).save(\"model.pt\"), or torch.jit.trace(model, example).save(...), in "
    "Python";

Error invalid(const std::string& offered) {
  return Error{.code = Code::MODEL_INVALID,
               .what = "the file is truncated, damaged or not a TorchScript model",
               .offered = offered,
               .needed = "a complete TorchScript archive",
               .fix = kSaveAsScript};
}

Error python_only(const std::string& offered) {
  return Error{.code = Code::MODEL_UNSUPPORTED,
               .what = "the file contains no program, only Python objects",
               .offered = offered,
               .needed = "a TorchScript archive, which contains code and weights",
               .fix = kSaveAsScript};
}

// A part of the file in memory, with access to little-endian numbers.
class Record {
 public:
  // False when the file has fewer than `count` bytes at `at`.
  bool read(const ModelSource& file, uint64_t at, size_t count) {
    bytes_.resize(count);
    return file.read(at, bytes_);
  }
  size_t size() const noexcept { return bytes_.size(); }
  // Precondition: at + sizeof(T) <= size().
  template <class T>
  T number(size_t at) const noexcept {
    T out = 0;
    std::memcpy(&out, bytes_.data() + at, sizeof out);
    return out;
  }
  std::string_view text() const noexcept {
    return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()};
  }

 private:
  std::vector<std::byte> bytes_;
};

struct Directory {
  uint64_t entries = 0, at = 0;
};

// Finds the record at the end, which a comment of up to 64 KiB may follow.
std::optional<Directory> find_directory(const ModelSource& file) {
  constexpr size_t kMaxComment = 0xFFFF;
  const auto tail =
      static_cast<size_t>(std::min<uint64_t>(file.size(), kLocatorBytes + kEndBytes + kMaxComment));
  Record end;
  if (tail < kEndBytes || !end.read(file, file.size() - tail, tail)) return std::nullopt;
  for (size_t at = tail - kEndBytes + 1; at-- > 0;) {
    if (end.number<uint32_t>(at) != kEnd) continue;
    Directory out{end.number<uint16_t>(at + 10), end.number<uint32_t>(at + 16)};
    if (at < kLocatorBytes || end.number<uint32_t>(at - kLocatorBytes) != kEnd64Locator) return out;
    Record end64;
    if (!end64.read(file, end.number<uint64_t>(at - kLocatorBytes + 8), kEnd64Bytes) ||
        end64.number<uint32_t>(0) != kEnd64)
      return out;
    return Directory{end64.number<uint64_t>(32), end64.number<uint64_t>(48)};
  }
  return std::nullopt;
}

// The bytes of an entry, including its header.
struct Extent {
  uint64_t begin = 0, end = 0;
};

struct Contents {
  bool code = false, data = false, constants = false;
  std::vector<CompressedEntry> compressed;
  std::set<std::string> names;
  std::vector<Extent> extents;
};

// "name/data.pkl" -> "data.pkl": every entry is in a folder with the model's name.
std::string_view inside(std::string_view name) {
  const size_t slash = name.find('/');
  return slash == std::string_view::npos ? name : name.substr(slash + 1);
}

// A stored entry; checksums are compared once all entries are known.
struct StoredEntry {
  std::string name;
  Extent data;
  uint32_t crc = 0;
};

class DirectoryReader {
 public:
  explicit DirectoryReader(const ModelSource& file) : file_(file) {}

  Result<Contents> read(const Directory& directory) {
    uint64_t at = directory.at;
    for (uint64_t i = 0; i < directory.entries; ++i) {
      Record entry;
      if (!entry.read(file_, at, kCentralBytes) || entry.number<uint32_t>(0) != kCentral)
        return invalid("entry " + std::to_string(i) + " of the archive is at the wrong offset");
      const auto name_bytes = entry.number<uint16_t>(28);
      const uint64_t rest =
          uint64_t{name_bytes} + entry.number<uint16_t>(30) + entry.number<uint16_t>(32);
      Record name;
      if (rest > file_.size() - at - kCentralBytes ||
          !name.read(file_, at + kCentralBytes, name_bytes))
        return invalid("the archive's directory is truncated");
      if (auto status = take(entry, std::string(name.text())); !status) return status.error();
      at += kCentralBytes + rest;
    }
    if (auto status = check_extents(); !status) return status.error();
    for (const auto& entry : stored_)
      if (auto status = check_crc(entry); !status) return status.error();
    return std::move(out_);
  }

 private:
  Status take(const Record& entry, const std::string& name) {
    const std::string part(inside(name));
    if (!out_.names.insert(part).second) return invalid(name + " is in the archive twice");
    out_.code = out_.code || part.starts_with("code/");
    out_.data = out_.data || part == "data.pkl";
    out_.constants = out_.constants || part == "constants.pkl";
    const auto method = entry.number<uint16_t>(10);
    const auto crc = entry.number<uint32_t>(16);
    const uint64_t packed = entry.number<uint32_t>(20), bytes = entry.number<uint32_t>(24);
    const uint64_t local = entry.number<uint32_t>(42);
    // Larger numbers are in a ZIP64 extra field: libtorch checks those entries itself.
    if (packed == UINT32_MAX || local == UINT32_MAX) return ok();
    Record header;
    if (!header.read(file_, local, kLocalBytes) || header.number<uint32_t>(0) != kLocal)
      return invalid(name + " does not lie within the archive");
    const uint64_t begin =
        local + kLocalBytes + header.number<uint16_t>(26) + header.number<uint16_t>(28);
    if (begin > file_.size() || packed > file_.size() - begin)
      return invalid(part + " does not lie within the archive");
    out_.extents.push_back({local, begin + packed});
    if (method == 8) {
      if (bytes / kMaxDeflated > packed)
        return invalid(part + " has an impossible compressed size");
      out_.compressed.push_back({part, crc});
      return ok();
    }
    if (method != 0 || packed != bytes) return invalid(part + " has an unknown compression method");
    stored_.push_back({part, {begin, begin + bytes}, crc});
    return ok();
  }

  // Entries that share bytes could make the content arbitrarily larger than the file.
  Status check_extents() {
    auto& extents = out_.extents;
    std::sort(extents.begin(), extents.end(),
              [](const Extent& a, const Extent& b) { return a.begin < b.begin; });
    for (size_t i = 1; i < extents.size(); ++i)
      if (extents[i].begin < extents[i - 1].end)
        return invalid("two entries of the archive share bytes at " +
                       std::to_string(extents[i].begin));
    return ok();
  }

  Status check_crc(const StoredEntry& entry) {
    uint32_t crc = 0;
    for (uint64_t at = entry.data.begin; at < entry.data.end; at += piece_.size()) {
      piece_.resize(static_cast<size_t>(std::min<uint64_t>(kPieceBytes, entry.data.end - at)));
      if (!file_.read(at, piece_)) return invalid(entry.name + " was truncated while it was read");
      crc = crc32(piece_, crc);
    }
    return crc == entry.crc ? ok() : Status(invalid(entry.name + " has a wrong checksum"));
  }

  const ModelSource& file_;
  Contents out_;
  std::vector<StoredEntry> stored_;
  std::vector<std::byte> piece_;
};

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

uint32_t crc32(std::span<const std::byte> bytes, uint32_t before) noexcept {
  static const auto table = [] {
    std::array<uint32_t, 256> out{};
    for (uint32_t i = 0; i < out.size(); ++i) {
      out[i] = i;
      for (int bit = 0; bit < 8; ++bit) out[i] = out[i] >> 1 ^ (out[i] & 1 ? 0xEDB88320u : 0);
    }
    return out;
  }();
  uint32_t crc = ~before;
  for (const std::byte byte : bytes)
    crc = crc >> 8 ^ table[(crc ^ static_cast<uint8_t>(byte)) & 0xFF];
  return ~crc;
}

Result<std::vector<CompressedEntry>> check_torch_file(const ModelSource& file) {
  std::array<std::byte, sizeof kOldPickle> head{};
  const std::span start(head.data(), std::min<uint64_t>(file.size(), head.size()));
  if (!file.read(0, start)) return invalid("the file cannot be read");
  if (begins_with({reinterpret_cast<const unsigned char*>(start.data()), start.size()}, kOldPickle))
    return python_only("a state dict or Python object, as torch.save() wrote it before 1.6");
  if (start.size() < 4 || std::memcmp(start.data(), "PK\3\4", 4) != 0)
    return invalid("not a zip archive");
  const auto directory = find_directory(file);
  if (!directory) return invalid("a truncated zip archive: its directory is missing");
  auto contents = DirectoryReader(file).read(*directory);
  if (!contents) return contents.error();
  if (contents->code && contents->data && contents->constants)
    return std::move(contents->compressed);
  if (contents->data)
    return python_only("a state dict or Python object, as torch.save() writes it");
  return invalid("a zip archive without data.pkl and code");
}

}  // namespace weir::engine
