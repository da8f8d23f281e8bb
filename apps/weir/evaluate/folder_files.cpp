// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/folder_files.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/text/text.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

template <class Keep>
std::vector<fs::path> sorted_entries(const fs::path& folder, Keep keep) {
  std::vector<fs::path> out;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (!entry.path().filename().string().starts_with(".") && keep(entry))
      out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

bool is_picture_name(const fs::path& path) {
  constexpr std::array kPictures{".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff"};
  const std::string extension = lower(path.extension().string());
  return std::find(kPictures.begin(), kPictures.end(), extension) != kPictures.end();
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  return sorted_entries(folder, [](const fs::directory_entry& entry) {
    std::error_code failed;
    return is_picture_name(entry.path()) && entry.is_regular_file(failed);
  });
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  return sorted_entries(folder, [](const fs::directory_entry& entry) {
    std::error_code failed;
    return entry.is_directory(failed);
  });
}

Result<std::string> read_file(const fs::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file && (file.peek() == std::ifstream::traits_type::eof() || text << file.rdbuf()))
    return text.str();
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "a file of the truth cannot be read",
               .offered = path.string(),
               .needed = "a file that can be read",
               .difference = errno ? std::strerror(errno) : ""};
}

std::string format_first(const std::vector<std::string>& names) {
  const std::string more = std::to_string(names.size() - 1);
  return names.size() == 1 ? names[0] : names[0] + " and " + more + " more";
}

}  // namespace weir::app
