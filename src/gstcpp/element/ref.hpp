// Ref<T>: shared ownership of one GStreamer reference. Unique: sole ownership of a C object.
// Mapped: a buffer or memory mapped for a scope.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>

namespace weir::gst {

template <class T>
concept MiniObject = requires(T* p) {
  { &p->mini_object } -> std::convertible_to<GstMiniObject*>;
};

template <class T>
class Ref {
 public:
  Ref() = default;
  static Ref adopt(T* p) { return Ref(p); }               // transfer full
  static Ref share(T* p) { return Ref(p ? ref(p) : p); }  // transfer none
  Ref(const Ref& o) : p_(o.p_ ? ref(o.p_) : nullptr) {}
  Ref(Ref&& o) noexcept : p_(std::exchange(o.p_, nullptr)) {}
  Ref& operator=(Ref o) noexcept {
    std::swap(p_, o.p_);
    return *this;
  }
  ~Ref() {
    if (p_) unref(p_);
  }

  T* get() const noexcept { return p_; }
  [[nodiscard]] T* release() noexcept { return std::exchange(p_, nullptr); }
  explicit operator bool() const noexcept { return p_ != nullptr; }
  bool operator==(const Ref&) const = default;  // the same object

 private:
  explicit Ref(T* p) : p_(p) {}
  static T* ref(T* p) {
    if constexpr (MiniObject<T>)
      gst_mini_object_ref(&p->mini_object);
    else
      gst_object_ref(p);
    return p;
  }
  static void unref(T* p) {
    if constexpr (MiniObject<T>)
      gst_mini_object_unref(&p->mini_object);
    else
      gst_object_unref(p);
  }
  T* p_ = nullptr;
};

template <auto Free>
struct Deleter {
  void operator()(auto* p) const { Free(p); }
};
template <class T, auto Free>
using Unique = std::unique_ptr<T, Deleter<Free>>;
using UniqueText = Unique<char, g_free>;

// Maps a whole buffer for the scope; GStreamer merges several memories into one.
class Mapped {
 public:
  Mapped(GstBuffer* b, GstMapFlags f) : buffer_(b), ok_(gst_buffer_map(b, &info_, f)) {}
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  ~Mapped() {
    if (ok_) gst_buffer_unmap(buffer_, &info_);
  }
  explicit operator bool() const noexcept { return ok_; }
  std::span<std::byte> bytes() const noexcept {
    return {reinterpret_cast<std::byte*>(info_.data), info_.size};
  }
  template <class T>
  std::span<T> as() const noexcept {
    return {reinterpret_cast<T*>(info_.data), info_.size / sizeof(T)};
  }

 private:
  GstBuffer* buffer_;
  GstMapInfo info_ = GST_MAP_INFO_INIT;
  bool ok_;
};

// Maps one memory for the lifetime of the object. Movable, so that it can be kept in a vector.
class MappedMemory {
 public:
  MappedMemory() = default;
  MappedMemory(GstMemory* memory, GstMapFlags flags) {
    if (gst_memory_map(memory, &info_, flags)) memory_ = memory;
  }
  MappedMemory(MappedMemory&& o) noexcept
      : memory_(std::exchange(o.memory_, nullptr)), info_(o.info_) {}
  MappedMemory& operator=(MappedMemory&& o) noexcept {
    std::swap(memory_, o.memory_);
    std::swap(info_, o.info_);
    return *this;
  }
  ~MappedMemory() {
    if (memory_) gst_memory_unmap(memory_, &info_);
  }
  explicit operator bool() const noexcept { return memory_ != nullptr; }
  std::span<std::byte> bytes() const noexcept {
    return {reinterpret_cast<std::byte*>(info_.data), info_.size};
  }
  size_t capacity() const noexcept { return info_.maxsize; }  // readable bytes from data on

 private:
  GstMemory* memory_ = nullptr;
  GstMapInfo info_ = GST_MAP_INFO_INIT;
};

}  // namespace weir::gst
