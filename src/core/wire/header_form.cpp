// The three forms of the nnstreamer-edge message header (docs/compatibility/edge-wire.md 10.2).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/header_form.hpp"

#include <array>
#include <string>
#include <tuple>

#include "core/wire/little_endian.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr uint64_t version_key(uint64_t major, uint64_t minor, uint64_t micro) {
  return uint64_t{kVersionTag} << 48 | micro << 24 | major << 12 | minor;
}

constexpr std::array<HeaderLayout, 3> kLayouts{{
    {"160-byte", 160, 16, 15, 0, 0, 8, 16, 24, 152},
    {"168-byte", 168, 16, 15, version_key(0, 2, 4), 8, 16, 24, 32, 160},
    {"2088-byte", 2088, 256, 255, version_key(0, 2, 6), 8, 16, 24, 32, 2080},
}};

// The bytes that contain the magic, the command and a version key.
constexpr size_t kStartBytes = 16;
constexpr size_t kVersionTagOffset = 14;
constexpr const HeaderLayout& kShort = kLayouts[1];

using Version = std::tuple<uint64_t, uint64_t, uint64_t>;
constexpr Version kBothForms{0, 2, 5};

Version find_version(uint64_t key) {
  return {key >> 12 & 0xFFF, key & 0xFFF, key >> 24 & 0xFFF};
}

Status check_magic(std::span<const std::byte> start) {
  const auto magic = read_little<uint32_t>(start, 0);
  if (magic == kEdgeMagic) return ok();
  const std::string_view text(reinterpret_cast<const char*>(start.data()), sizeof magic);
  return peer_error("a connection does not begin with an nnstreamer-edge message",
                    "the bytes " + quoted_text(text), "the magic number 0xfeedfeed, little-endian");
}

// Whether `start` is a whole message of the 168-byte form if it has no text or an empty one.
bool is_short_message_without_text(std::span<const std::byte> start) {
  const auto count = read_little<uint32_t>(start, kShort.count_offset);
  if (count == 0) return start.size() == kShort.bytes;
  return count == 1 && read_little<uint64_t>(start, kShort.sizes_offset) == 1 &&
         start.size() == kShort.bytes + 1 && start[kShort.bytes] == std::byte{0};
}

}  // namespace

const HeaderLayout& get_layout(HeaderForm form) noexcept {
  return kLayouts[static_cast<size_t>(form)];
}

bool version_may_have(uint64_t key, HeaderForm form) noexcept {
  if (key >> 48 != kVersionTag) return false;
  if (form == HeaderForm::Bytes168) return find_version(key) <= kBothForms;
  return form == HeaderForm::Bytes2088 && find_version(key) >= kBothForms;
}

Result<FormDecision> recognise_form(std::span<const std::byte> start) {
  if (start.size() >= sizeof kEdgeMagic)
    if (auto status = check_magic(start); !status) return status.error();
  if (start.size() < kStartBytes) return FormDecision{.needed = kStartBytes};
  if (read_little<uint16_t>(start, kVersionTagOffset) != kVersionTag)
    return FormDecision{.form = HeaderForm::Bytes160};
  const auto version = find_version(read_little<uint64_t>(start, kShort.version_offset));
  if (version < kBothForms) return FormDecision{.form = HeaderForm::Bytes168};
  if (version > kBothForms) return FormDecision{.form = HeaderForm::Bytes2088};
  // 0.2.5 has both: offset 168 is the text of the short form and an unused size of the long one.
  const size_t text = kShort.bytes;
  if (start.size() <= text) return FormDecision{.needed = text + 1};
  if (start[text] != std::byte{0}) return FormDecision{.form = HeaderForm::Bytes168};
  if (is_short_message_without_text(start)) return FormDecision{.needed = text + 2};
  return FormDecision{.form = HeaderForm::Bytes2088};
}

std::optional<HeaderForm> form_after_silence(std::span<const std::byte> start) {
  const auto decision = recognise_form(start);
  if (!decision) return std::nullopt;
  if (decision->form) return decision->form;
  if (start.size() < kShort.bytes || !is_short_message_without_text(start)) return std::nullopt;
  return HeaderForm::Bytes168;
}

}  // namespace weir::wire
