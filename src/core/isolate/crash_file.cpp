// Writes flexible tensors one after another, which readers of flexible streams take as one frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/crash_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>

#include "core/tensor/model_tensor.hpp"
#include "core/tensor/tensor_header.hpp"
#include "core/text/shell_quote.hpp"
#include "machine/descriptor.hpp"

namespace weir::isolate {
namespace {

Error not_written(const std::string& path, const std::string& reason) {
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "a frame that terminated a worker process cannot be saved",
               .offered = path + ": " + reason,
               .needed = "a writable folder",
               .fix = "crash-folder=/tmp"};
}

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
  return true;
}

// Creates a file with an unused name: weir-frame-PID-NUMBER.tensors
io::Descriptor new_file(const std::string& folder, std::string* path) {
  constexpr int kMaxNames = 10000;
  for (int number = 1; number <= kMaxNames; ++number) {
    *path = (std::filesystem::path(folder) /
             ("weir-frame-" + std::to_string(getpid()) + "-" + std::to_string(number) + ".tensors"))
                .string();
    io::Descriptor file(
        open(path->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR));
    if (file || errno != EEXIST) return file;
  }
  return {};
}

}  // namespace

std::string CrashFile::line(const std::string& element) const {
  return "gst-launch-1.0 filesrc location=" + launch_value(path) +
         " blocksize=" + std::to_string(bytes) +
         " ! other/tensors,format=flexible,framerate=0/1 ! " + element + " ! fakesink";
}

Result<CrashFile> save_frame(const std::string& folder, const weir_frame& frame) {
  CrashFile out;
  const io::Descriptor file = new_file(folder, &out.path);
  if (!file) return not_written(out.path, std::strerror(errno));
  for (uint32_t i = 0; i < frame.n_tensors; ++i) {
    const weir_tensor& tensor = frame.tensors[i];
    TensorHeader header;
    header.spec = to_spec(model_tensor(tensor.info));
    if (header.spec.bytes() != tensor.bytes) {
      unlink(out.path.c_str());
      return not_written(out.path, "tensor " + std::to_string(i) + " has an open shape");
    }
    std::array<std::byte, kTensorHeaderBytes> head{};
    write_tensor_header(header, head);
    if (!write_all(file.get(), head) ||
        !write_all(file.get(), {static_cast<const std::byte*>(tensor.data), tensor.bytes})) {
      const std::string reason = std::strerror(errno);
      unlink(out.path.c_str());
      return not_written(out.path, reason);
    }
    out.bytes += head.size() + tensor.bytes;
  }
  return out;
}

}  // namespace weir::isolate
