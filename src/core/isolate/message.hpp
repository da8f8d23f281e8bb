// Messages between a pipeline and its worker process, written and read with bounds checks. Both
// ends are of the same build; input is validated nevertheless.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace weir::isolate {

// Increment it with every change of a message: workers of another version are rejected.
inline constexpr uint32_t kProtocol = 5;

enum class Kind : uint32_t {
  // From the worker, once: protocol version, the two texts of Confinement.
  Hello = 1,
  // To the worker, with its reply.
  Open,     // -> Opened: describes the model
  Block,    // a shared memory with its descriptor; no reply
  Forget,   // a block that is no longer used; no reply
  Resolve,  // -> Resolved: shapes of the outputs, and how the engine runs the model
  Invoke,   // -> Invoked: the outputs
  Fetch,    // -> Done: outputs that the engine allocated are in the block
  Control,  // -> Done
  // Replies.
  Opened,
  Resolved,
  Invoked,
  Done,
  Failed,  // an error of the engine or module
};

inline constexpr uint32_t kMaxMessageBytes = 16u << 20;

struct MessageHead {
  uint32_t kind, bytes;  // bytes after the head
};

class MessageWriter {
 public:
  // Keeps the memory: a reused writer does not allocate. `kind`: an enumeration of the protocol.
  template <class E>
  void begin(E kind) requires std::is_enum_v<E> {
    bytes_.clear();
    put(MessageHead{static_cast<uint32_t>(kind), 0});
  }
  template <class T>
  void put(const T& value) requires std::is_trivially_copyable_v<T> {
    append(&value, sizeof value);
  }
  void text(std::string_view text) {
    put(static_cast<uint32_t>(text.size()));
    append(text.data(), text.size());
  }
  // Without their size.
  void bytes(std::span<const std::byte> bytes) { append(bytes.data(), bytes.size()); }
  // Head and body, with the length set.
  std::span<const std::byte> finish() {
    const auto size = static_cast<uint32_t>(bytes_.size() - sizeof(MessageHead));
    std::memcpy(bytes_.data() + offsetof(MessageHead, bytes), &size, sizeof size);
    return bytes_;
  }

 private:
  void append(const void* from, size_t size) {
    const size_t at = bytes_.size();
    bytes_.resize(at + size);
    if (size > 0) std::memcpy(bytes_.data() + at, from, size);
  }
  std::vector<std::byte> bytes_;
};

// Reads the output of MessageWriter. Reading beyond the end yields 0 or "", which complete()
// reports.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  T take() requires std::is_trivially_copyable_v<T> {
    T value{};
    if (const auto part = bytes(sizeof value); !part.empty())
      std::memcpy(&value, part.data(), sizeof value);
    return value;
  }
  std::string text() {
    const auto part = bytes(take<uint32_t>());
    return {reinterpret_cast<const char*>(part.data()), part.size()};
  }
  // Everything that is left.
  std::span<const std::byte> rest() { return bytes(rest_.size()); }
  // The number of items that follow; more than `max` invalidates the message.
  uint32_t count(uint32_t max) {
    const auto value = take<uint32_t>();
    if (value <= max) return value;
    spoiled_ = true;
    return 0;
  }
  bool is_spoiled() const noexcept { return spoiled_; }  // something was missing
  // True if everything was present and nothing is left.
  bool complete() const noexcept { return !spoiled_ && rest_.empty(); }

 private:
  std::span<const std::byte> bytes(size_t size) {
    if (size > rest_.size()) {
      spoiled_ = true;
      rest_ = {};
      return {};
    }
    const auto part = rest_.first(size);
    rest_ = rest_.subspan(size);
    return part;
  }

  std::span<const std::byte> rest_;
  bool spoiled_ = false;
};

}  // namespace weir::isolate
