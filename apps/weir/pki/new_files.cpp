// Writes temporary files beside their places, and links them there.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pki/new_files.hpp"
#include "core/text/shell_quote.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace weir::app {
namespace {

namespace fs = std::filesystem;

Error not_written(const fs::path& path, int error) {
  if (error == EEXIST)
    return Error{
        .code = Code::FILE_NOT_WRITTEN,
        .what = "a file with this name already exists and is not replaced",
        .offered = path.string(),
        .needed = "a name that is not in use",
        .fix = "mv " + shell_word(path.string()) + " " + shell_word(path.string() + ".old")};
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "a file cannot be written: " + std::generic_category().message(error),
               .offered = path.string(),
               .needed = "a folder that you may write to",
               .fix = "choose another folder, or correct the permissions of this one"};
}

// Writes a file of any name in the folder of `file`. 0, or errno.
int write_temporary(const NewFile& file, std::string* name) {
  const int descriptor = mkostemp(name->data(), O_CLOEXEC);
  if (descriptor < 0) return errno;
  int error = fchmod(descriptor, file.mode) == 0 ? 0 : errno;
  for (size_t done = 0; error == 0 && done < file.text.size();) {
    const ssize_t count = ::write(descriptor, file.text.data() + done, file.text.size() - done);
    if (count >= 0)
      done += static_cast<size_t>(count);
    else if (errno != EINTR)
      error = errno;
  }
  if (error == 0 && fsync(descriptor) != 0) error = errno;
  close(descriptor);
  return error;
}

void sync_folder(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

Status write_new_files(const std::vector<NewFile>& files) {
  std::vector<fs::path> written;
  for (const NewFile& file : files) {
    const fs::path folder = file.path.has_parent_path() ? file.path.parent_path() : ".";
    std::string temporary = folder / ("." + file.path.filename().string() + ".XXXXXX");
    int error = write_temporary(file, &temporary);
    // Unlike rename, link does not replace a file.
    if (error == 0 && link(temporary.c_str(), file.path.c_str()) != 0) error = errno;
    unlink(temporary.c_str());
    if (error != 0) {
      for (const auto& path : written) unlink(path.c_str());
      return not_written(file.path, error);
    }
    written.push_back(file.path);
    sync_folder(folder);
  }
  return ok();
}

}  // namespace weir::app
