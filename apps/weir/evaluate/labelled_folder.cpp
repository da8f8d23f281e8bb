// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/labelled_folder.hpp"

#include <glib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>

#include "core/evaluate/coco_truth.hpp"
#include "core/text/shell_quote.hpp"
#include "evaluate/folder_files.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

// Without model cards, which lie next to models.
std::vector<fs::path> json_files_in(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (const std::string name = entry.path().filename().string();
        name.ends_with(".json") && !name.ends_with(".card.json"))
      out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

// Where pictures may be: the folder, images/, then all other folders below it.
std::vector<fs::path> places_of_pictures(const fs::path& folder) {
  std::vector<fs::path> out{folder, folder / "images"};
  for (const fs::path& below : folders_in(folder))
    if (below.filename() != "images") out.push_back(below);
  return out;
}

// A name that leads out of the folder could be any file of the machine.
bool leads_out(const fs::path& name) {
  return name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end();
}

Error outside_error(const fs::path& folder, const std::string& truth, const std::string& name,
                    std::string fix) {
  return {.code = Code::LABELS_INVALID,
          .what = "the name of a picture points outside the folder",
          .offered = truth + ": " + name,
          .needed = "a name below " + folder.string(),
          .fix = std::move(fix)};
}

void warn(std::string what, const std::vector<std::string>& names, std::string needed,
          std::string fix, LabelledFolder* out) {
  if (names.empty()) return;
  out->warnings.push_back({.code = Code::LABELS_INVALID,
                           .what = std::move(what),
                           .offered = out->truth + ": " + format_first(names),
                           .needed = std::move(needed),
                           .fix = std::move(fix)});
}

// Pictures beside those of the truth that the truth does not have.
std::vector<std::string> unlisted(const std::set<fs::path>& listed) {
  std::set<fs::path> folders;
  for (const fs::path& path : listed) folders.insert(path.parent_path());
  std::vector<std::string> out;
  for (const fs::path& folder : folders)
    for (const fs::path& picture : pictures_in(folder))
      if (!listed.contains(picture)) out.push_back(picture.string());
  return out;
}

std::string frame_name(uint32_t number, const std::string& extension) {
  std::array<char, 16> digits{};
  std::snprintf(digits.data(), digits.size(), "%06u", number);
  return digits.data() + extension;
}

Result<LabelledSequence> read_sequence(const fs::path& folder) {
  const fs::path info_path = folder / "seqinfo.ini", truth_path = folder / "gt" / "gt.txt";
  const auto info_text = read_file(info_path);
  if (!info_text) return info_text.error();
  const auto info = evaluate::parse_sequence_info(info_path.string(), *info_text);
  if (!info) return info.error();
  const fs::path first = fs::path(info->folder) / frame_name(1, info->extension);
  if (leads_out(first))
    return outside_error(folder, info_path.string(), first.string(), "imDir=img1 and imExt=.jpg");
  const auto truth_text = read_file(truth_path);
  if (!truth_text) return truth_text.error();
  auto truth = evaluate::parse_mot_truth(truth_path.string(), *truth_text, *info);
  if (!truth) return truth.error();
  // "sequence/" has an empty file name.
  const fs::path named = folder.has_filename() ? folder : folder.parent_path();
  LabelledSequence out{
      .name = named.filename().string(), .frame_rate = info->frame_rate, .is_video = true};
  for (uint32_t i = 0; i < info->frames; ++i) {
    const fs::path picture = folder / info->folder / frame_name(i + 1, info->extension);
    std::error_code ignored;
    if (!fs::is_regular_file(picture, ignored))
      return Error{.code = Code::FILE_NOT_FOUND,
                   .what = "a picture of the sequence does not exist",
                   .offered = picture.string(),
                   .needed = "frames 1 to " + std::to_string(info->frames) + ", as " +
                             info_path.string() + " says",
                   .fix = "add the picture, or correct seqLength, imDir or imExt"};
    out.pictures.push_back({.path = picture.string(),
                            .width = info->width,
                            .height = info->height,
                            .tracks = std::move((*truth)[i])});
  }
  return out;
}

// The one JSON file of the folder or of its folder annotations/; "" if there is none. OPTION_VALUE
// if there are several.
Result<std::string> find_annotation_file(const fs::path& folder) {
  auto files = json_files_in(folder);
  if (files.empty()) files = json_files_in(folder / "annotations");
  if (files.size() < 2) return files.empty() ? std::string() : files[0].string();
  return Error{.code = Code::OPTION_VALUE,
               .what = "the folder has several annotation files",
               .offered = join(files, ", ", [](const fs::path& file) { return file.string(); }),
               .needed = "the option that chooses one",
               .fix = "--truth " + shell_word(files[0].string())};
}

// Pictures are looked for in the folder, in its folder images/ and in the other folders below it.
Result<LabelledFolder> read_annotated(const fs::path& folder, const std::string& annotations) {
  const auto text = read_file(annotations);
  if (!text) return text.error();
  auto truth = evaluate::parse_coco_truth(annotations, *text);
  if (!truth) return truth.error();
  LabelledFolder out{.kind = Labelled::Objects,
                     .truth = annotations,
                     .categories = std::move(truth->categories),
                     .key_points = truth->key_points,
                     .sequences = {{}},
                     .warnings = std::move(truth->warnings)};
  std::vector<std::string> missing;
  std::set<fs::path> listed;
  const auto places = places_of_pictures(folder);
  for (auto& picture : truth->pictures) {
    if (leads_out(picture.file))
      return outside_error(folder, annotations, picture.file, "correct file_name");
    const auto place = std::find_if(places.begin(), places.end(), [&](const fs::path& where) {
      std::error_code ignored;
      return fs::is_regular_file(where / picture.file, ignored);
    });
    if (place == places.end()) {
      missing.push_back(picture.file);
      continue;
    }
    const fs::path path = *place / picture.file;
    listed.insert(path);
    out.sequences[0].pictures.push_back({.path = path.string(),
                                         .width = picture.width,
                                         .height = picture.height,
                                         .objects = std::move(picture.objects)});
  }
  warn("annotations without a picture are ignored", missing,
       "the file, in " + folder.string() + " or a folder below it", "add the pictures", &out);
  warn("pictures without annotations are ignored", unlisted(listed),
       "an entry in \"images\", even for pictures without objects", "add the entries", &out);
  return out;
}

// it has seqinfo.ini
bool is_sequence(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / "seqinfo.ini", ignored);
}

bool has_sequences(const fs::path& folder) {
  const auto folders = folders_in(folder);
  return std::any_of(folders.begin(), folders.end(), is_sequence);
}

Result<LabelledFolder> read_sequences(const fs::path& folder) {
  LabelledFolder out{.kind = Labelled::Tracks, .truth = folder.string()};
  std::vector<fs::path> folders{folder};
  if (!is_sequence(folder)) {
    folders = folders_in(folder);
    std::erase_if(folders, [](const fs::path& path) { return !is_sequence(path); });
  }
  for (const fs::path& path : folders) {
    auto sequence = read_sequence(path);
    if (!sequence) return sequence.error();
    out.sequences.push_back(*std::move(sequence));
  }
  return out;
}

constexpr char kLayouts[] =
    "a COCO annotation file with pictures; a folder of pictures for each class; images/ and "
    "masks/; seqinfo.ini, gt/gt.txt and img1/ of MOTChallenge";

std::string make_digest(const std::string& bytes) {
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
      const auto [first, is_new] = seen.try_emplace(make_digest(*bytes), picture.string(), index);
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
                           .offered = format_first(lonely),
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
  const auto annotations = find_annotation_file(folder);
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
