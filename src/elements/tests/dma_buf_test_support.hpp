// DMA-BUFs for tests: memory files that emulate them, real ones if a graphics driver creates them,
// and a watch on the ioctls that start and end CPU access.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fcntl.h>
#include <linux/dma-buf.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <atomic>
#include <cstdarg>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace weir::testing_memory {

constexpr size_t kPage = 4096;

// A memory file that starts with these bytes; the caller owns it.
inline int make_file(const std::vector<uint8_t>& bytes) {
  const int file = memfd_create("weir-test", MFD_CLOEXEC);
  EXPECT_EQ(write(file, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  return file;
}

// The kernel's interface to graphics drivers, as in drm/drm.h and drm/drm_mode.h.
struct DumbBuffer {
  uint32_t height = 1, width = kPage / 4, bits_per_pixel = 32, flags = 0, handle = 0, pitch = 0;
  uint64_t size = 0;
};
struct SharedBuffer {
  uint32_t handle = 0, flags = O_CLOEXEC | O_RDWR;
  int32_t file = -1;
};
constexpr unsigned long kCreateDumbBuffer = _IOWR('d', 0xB2, DumbBuffer);
constexpr unsigned long kShareBuffer = _IOWR('d', 0x2D, SharedBuffer);

// A page of a graphics driver as a DMA-BUF (vgem creates them without a device). The caller owns
// it; -1 if no driver provides one.
inline int dma_buf_page() {
  for (int number = 0; number < 16; ++number) {
    const int card = open(("/dev/dri/card" + std::to_string(number)).c_str(), O_RDWR | O_CLOEXEC);
    if (card < 0) continue;
    DumbBuffer made;
    SharedBuffer shared;
    if (ioctl(card, kCreateDumbBuffer, &made) == 0) {
      shared.handle = made.handle;
      ioctl(card, kShareBuffer, &shared);
    }
    close(card);  // the exported buffer stays valid
    if (shared.file >= 0) return shared.file;
  }
  return -1;
}

// A DMA-BUF that starts with these bytes.
inline int make_dma_buf(const std::vector<uint8_t>& bytes) {
  const int file = dma_buf_page();
  dma_buf_sync access{DMA_BUF_SYNC_START | DMA_BUF_SYNC_WRITE};
  EXPECT_EQ(ioctl(file, DMA_BUF_IOCTL_SYNC, &access), 0);
  void* page = mmap(nullptr, kPage, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  EXPECT_NE(page, MAP_FAILED);
  if (page != MAP_FAILED) std::memcpy(page, bytes.data(), bytes.size());
  munmap(page, kPage);
  access.flags = DMA_BUF_SYNC_END | DMA_BUF_SYNC_WRITE;
  EXPECT_EQ(ioctl(file, DMA_BUF_IOCTL_SYNC, &access), 0);
  return file;
}

inline bool can_make_dma_bufs() {
  const int file = dma_buf_page();
  if (file >= 0) close(file);
  return file >= 0;
}

// Counts DMA-BUF syncs, including those on ordinary files. One instance per process at a time.
class SyncWatch {
 public:
  SyncWatch() { watch_ = this; }
  SyncWatch(const SyncWatch&) = delete;
  SyncWatch& operator=(const SyncWatch&) = delete;
  ~SyncWatch() { watch_ = nullptr; }
  int begun() const { return begun_; }
  int ended() const { return ended_; }
  int refused() const { return refused_; }  // by the kernel

  static int ioctl(int file, unsigned long request, void* argument) {
    const auto result = static_cast<int>(syscall(SYS_ioctl, file, request, argument));
    SyncWatch* watch = watch_;
    if (request != DMA_BUF_IOCTL_SYNC || !watch) return result;
    const bool ends = static_cast<const dma_buf_sync*>(argument)->flags & DMA_BUF_SYNC_END;
    ++(ends ? watch->ended_ : watch->begun_);
    if (result < 0) ++watch->refused_;
    return 0;
  }

 private:
  static inline std::atomic<SyncWatch*> watch_{nullptr};
  std::atomic<int> begun_{0}, ended_{0}, refused_{0};
};

}  // namespace weir::testing_memory
