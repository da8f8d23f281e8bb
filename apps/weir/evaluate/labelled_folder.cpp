// Recognises the layout of a folder, and reads classes and class maps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/labelled_folder.hpp"

#include <glib.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "evaluate/annotated_folder.hpp"
#include "evaluate/folder_files.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

constexpr char kLayouts[] =
    "a COCO annotation file with pictures; a folder of pictures for each class; images/ and "
    "masks/; seqinfo.ini, gt/gt.txt and img1/ of MOTChallenge";

std::string digest_of(const std::string& bytes) {
  const gst::UniqueText digest(g_compute_checksum_for_data(
      G_CHECKSUM_SHA256, reinterpret_cast<const guchar*>(bytes.data()), bytes.size()));
  return digest.get();
}

// FOLDER/CLASS/*.jpg. A picture that is in two classes contradicts itself.
Result<LabelledFolder> read_classes(const fs::path& folder) {
  LabelledFolder out{.kind = Labelled::Classes, .truth = folder.string(), .sequences = {{}}};
  std::map<std::string, std::pair<std::string, size_t>> seen;  // by digest: path and class
  for (const fs::path& of_class : folders_in(folder)) {
    const auto pictures = pictures_in(of_class);
    if (pictures.empty()) {
      out.warnings.push_back({.code = Code::FILE_NOT_FOUND,
                              .what = "the folder of a class has no pictures",
                              .offered = of_class.string(),
                              .needed = "pictures: .jpg, .png, .bmp, .webp or .tif",
                              .fix = "delete the folder, or add pictures"});
      continue;
    }
    const size_t index = out.categories.size();
    out.categories.push_back(of_class.filename().string());
    for (const fs::path& picture : pictures) {
      const auto bytes = read_file(picture);
      if (!bytes) return bytes.error();
      const auto [first, is_new] = seen.try_emplace(digest_of(*bytes), picture.string(), index);
      if (!is_new && first->second.second != index)
        return Error{.code = Code::LABELS_INVALID,
                     .what = "the same picture is in two classes",
                     .offered = first->second.first + " and " + picture.string(),
                     .needed = "one class for each picture",
                     .fix = "delete one of the two files"};
      out.sequences[0].pictures.push_back({.path = picture.string(), .class_index = index});
    }
  }
  return out;
}

// Pictures and masks that have no counterpart.
void warn_about_pairs(const std::vector<std::string>& lonely, const char* what, const char* fix,
                      LabelledFolder* out) {
  if (lonely.empty()) return;
  out->warnings.push_back({.code = Code::LABELS_INVALID,
                           .what = what,
                           .offered = first_of(lonely),
                           .needed = "images/NAME.jpg and masks/NAME.png with the same NAME",
                           .fix = fix});
}

Result<LabelledFolder> read_maps(const fs::path& folder) {
  LabelledFolder out{
      .kind = Labelled::Maps, .truth = (folder / "masks").string(), .sequences = {{}}};
  std::map<std::string, std::string> masks;
  for (const fs::path& mask : pictures_in(folder / "masks")) masks[mask.stem().string()] = mask;
  std::vector<std::string> without_mask, without_picture;
  for (const fs::path& picture : pictures_in(folder / "images")) {
    const auto mask = masks.find(picture.stem().string());
    if (mask == masks.end()) {
      without_mask.push_back(picture.string());
      continue;
    }
    out.sequences[0].pictures.push_back({.path = picture.string(), .mask = mask->second});
    masks.erase(mask);
  }
  for (const auto& [name, path] : masks) without_picture.push_back(path);
  warn_about_pairs(without_mask, "pictures without a mask are left out", "add the masks", &out);
  warn_about_pairs(without_picture, "masks without a picture are left out", "add the pictures",
                   &out);
  return out;
}

Error no_folder(const std::string& path) {
  std::error_code ignored;
  const bool exists = fs::exists(path, ignored);
  return {.code = Code::FILE_NOT_FOUND,
          .what = exists ? "this is a file, not a folder" : "the labelled folder does not exist",
          .offered = path,
          .needed = "a folder with pictures and the truth about them",
          .fix = "weir evaluate MODEL path/to/folder"};
}

Error unknown_layout(const fs::path& folder) {
  std::error_code ignored;
  const bool is_empty = fs::is_empty(folder, ignored);
  return {.code = Code::FILE_NOT_FOUND,
          .what = is_empty ? "the labelled folder is empty"
                           : "the folder has no truth in a known layout",
          .offered = folder.string(),
          .needed = std::string("one of: ") + kLayouts,
          .fix = "--truth FILE, if the annotation file has another name"};
}

Result<LabelledFolder> read_by_layout(const EvaluateOptions& options) {
  const fs::path folder = options.folder;
  std::error_code ignored;
  if (!options.truth.empty()) return read_annotated(folder, options.truth);
  if (is_sequence(folder) || has_sequences(folder)) return read_sequences(folder);
  const auto annotations = annotation_file_of(folder);
  if (!annotations) return annotations.error();
  if (!annotations->empty()) return read_annotated(folder, *annotations);
  if (fs::is_directory(folder / "images", ignored) && fs::is_directory(folder / "masks", ignored))
    return read_maps(folder);
  if (!folders_in(folder).empty()) return read_classes(folder);
  return unknown_layout(folder);
}

}  // namespace

size_t LabelledFolder::pictures() const noexcept {
  size_t out = 0;
  for (const auto& sequence : sequences) out += sequence.pictures.size();
  return out;
}

Result<LabelledFolder> read_labelled_folder(const EvaluateOptions& options) {
  std::error_code ignored;
  if (!fs::is_directory(options.folder, ignored)) return no_folder(options.folder);
  auto out = read_by_layout(options);
  if (!out) return out;
  if (out->pictures() == 0)
    return Error{.code = Code::FILE_NOT_FOUND,
                 .what = "the folder has no pictures with truth",
                 .offered = options.folder,
                 .needed = "pictures that the truth names: .jpg, .png, .bmp, .webp or .tif",
                 .difference = out->warnings.empty() ? "" : out->warnings[0].offered,
                 .fix = "weir evaluate MODEL FOLDER, with the folder that contains the pictures"};
  if (options.limit > 0)
    for (auto& sequence : out->sequences)
      if (sequence.pictures.size() > options.limit) sequence.pictures.resize(options.limit);
  return out;
}

}  // namespace weir::app
