// Writes zip records (PKWARE's appnote) and the pickle of a module whose only attribute is
// `training`.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pytorch/torchscript_builder_test_support.hpp"

#include <cstdint>

namespace weir::engine_test {
namespace {

uint32_t crc32(const std::string& text) {
  uint32_t crc = ~0u;
  for (const char c : text) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
  }
  return ~crc;
}

class Writer {
 public:
  Writer& u16(size_t value) { return bytes(value, 2); }
  Writer& u32(size_t value) { return bytes(value, 4); }
  Writer& text(const std::string& value) { return out_ += value, *this; }
  const std::string& result() const { return out_; }

 private:
  Writer& bytes(size_t value, int count) {
    for (int i = 0; i < count; ++i) out_ += static_cast<char>(value >> 8 * i & 0xFF);
    return *this;
  }
  std::string out_;
};

// The fields shared by a local header and the directory's entry.
void describe(const std::string& name, const std::string& content, Writer* out) {
  out->u16(20).u16(0).u16(0).u16(0).u16(0);  // version, flags, stored, time, date
  out->u32(crc32(content)).u32(content.size()).u32(content.size()).u16(name.size()).u16(0);
}

}  // namespace

std::vector<std::byte> zip(const ZipEntries& entries) {
  Writer out, directory;
  for (const auto& [name, content] : entries) {
    const size_t at = out.result().size();
    out.u32(0x04034b50);
    describe(name, content, &out);
    out.text(name).text(content);
    directory.u32(0x02014b50).u16(20);
    describe(name, content, &directory);
    directory.u16(0).u16(0).u16(0).u32(0).u32(at).text(name);
  }
  const size_t at = out.result().size();
  out.text(directory.result());
  out.u32(0x06054b50).u16(0).u16(0).u16(entries.size()).u16(entries.size());
  out.u32(directory.result().size()).u32(at).u16(0);
  const auto* begin = reinterpret_cast<const std::byte*>(out.result().data());
  return {begin, begin + out.result().size()};
}

ZipEntries torchscript_entries(const std::string& methods, const std::string& version) {
  std::string code =
      "class M(Module):\n  __parameters__ = []\n  __buffers__ = []\n  training : bool\n  ";
  for (const char c : methods) code += c == '\n' ? std::string("\n  ") : std::string(1, c);
  // GLOBAL __torch__ M, EMPTY_TUPLE, NEWOBJ, EMPTY_DICT, MARK, "training", True, SETITEMS, BUILD
  const std::string name("\x08\0\0\0training", 12);
  const std::string object =
      "\x80\x02"
      "c__torch__\nM\n)\x81}(X" +
      name + "\x88ub.";
  return {{"m/data.pkl", object},
          {"m/code/__torch__.py", code + "\n"},
          {"m/constants.pkl", "\x80\x02)."},
          {"m/version", version + "\n"}};
}

std::vector<std::byte> torchscript(const std::string& methods, const std::string& version) {
  return zip(torchscript_entries(methods, version));
}

}  // namespace weir::engine_test
