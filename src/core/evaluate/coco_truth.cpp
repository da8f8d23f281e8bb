// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/coco_truth.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/text/error_text.hpp"
#include "core/text/json_depth.hpp"

namespace weir::evaluate {
namespace {

constexpr int kDepthLimit = 64;  // polygons of objects are lists at depth 5

using Json = nlohmann::json;

// What stops the reading. Caught in parse_coco_truth().
struct Refused {
  Error error;
};

class Reader {
 public:
  Reader(const std::string& path, const Json& root) : path_(path), root_(root) {}

  CocoTruth read() {
    read_categories();
    read_pictures();
    read_annotations();
    warn_about_edges();
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse(std::string what, const std::string& offered, std::string needed,
                           std::string fix) const {
    throw Refused{{.code = Code::LABELS_INVALID,
                   .what = std::move(what),
                   .offered = path_ + ": " + offered,
                   .needed = std::move(needed),
                   .fix = std::move(fix)}};
  }

  const Json& list(const char* name) const {
    if (root_.is_object() && root_.contains(name) && root_[name].is_array()) return root_[name];
    refuse("the file is not a COCO annotation file", std::string("no list \"") + name + "\"",
           "an object with the lists images, annotations and categories",
           "--truth FILE, if the annotation file has another name");
  }
  static std::string place(const char* name, size_t index) {
    return std::string(name) + "[" + std::to_string(index) + "]";
  }
  int64_t integer(const Json& entry, const char* key, const std::string& at) const {
    if (entry.is_object() && entry.contains(key) && entry[key].is_number_integer())
      return entry[key].get<int64_t>();
    refuse("an entry has no whole number \"" + std::string(key) + "\"", at,
           "\"" + std::string(key) + "\": a whole number", "add it to the entry");
  }
  std::string text(const Json& entry, const char* key, const std::string& at) const {
    if (entry.is_object() && entry.contains(key) && entry[key].is_string() &&
        !entry[key].get_ref<const std::string&>().empty())
      return entry[key].get<std::string>();
    refuse("an entry has no string \"" + std::string(key) + "\"", at,
           "\"" + std::string(key) + "\": a string", "add it to the entry");
  }
  std::vector<double> numbers(const Json& list, size_t count, const std::string& at) const {
    std::vector<double> out;
    if (list.is_array())
      for (const Json& number : list)
        if (number.is_number()) out.push_back(number.get<double>());
    if (out.size() == count && list.size() == count) return out;
    refuse("a list does not have the numbers that it needs", at,
           std::to_string(count) + " finite numbers", "correct the entry, or delete it");
  }

  // Rising ids; the index of each in `categories`.
  void read_categories() {
    std::map<int64_t, std::string> names;
    std::set<std::string> seen;
    const Json& all = list("categories");
    for (size_t i = 0; i < all.size(); ++i) {
      const std::string at = place("categories", i);
      const int64_t id = integer(all[i], "id", at);
      const std::string name = text(all[i], "name", at);
      if (!names.emplace(id, name).second)
        refuse("two categories have the same id", at + ", id " + std::to_string(id),
               "a unique id for each category", "delete one of them");
      if (!seen.insert(name).second)
        refuse("two categories have the same name", at + ", " + name,
               "a unique name for each category", "give both annotations the same category_id");
    }
    if (names.empty())
      refuse("the annotation file has no categories", "\"categories\": []", "one category or more",
             "{\"id\": 1, \"name\": \"person\"} in the list");
    for (const auto& [id, name] : names) {
      category_of_[id] = out_.categories.size();
      out_.categories.push_back(name);
    }
  }

  uint32_t length(const Json& entry, const char* key, const std::string& at) const {
    if (!entry.contains(key)) return 0;
    const int64_t value = integer(entry, key, at);
    if (value > 0 && value <= INT32_MAX) return static_cast<uint32_t>(value);
    refuse("the size of a picture is not valid", at + ", \"" + key + "\": " + std::to_string(value),
           "the size in pixels", "correct it, or leave it out");
  }

  void read_pictures() {
    std::set<std::string> files;
    const Json& all = list("images");
    for (size_t i = 0; i < all.size(); ++i) {
      const std::string at = place("images", i);
      const int64_t id = integer(all[i], "id", at);
      const std::string file = text(all[i], "file_name", at);
      if (!picture_of_.emplace(id, out_.pictures.size()).second)
        refuse("two pictures have the same id", at + ", id " + std::to_string(id),
               "a unique id for each picture", "delete one of them");
      if (!files.insert(file).second)
        refuse("a picture is listed twice", at + ", " + file, "an entry for each file",
               "give all its annotations the same image_id");
      out_.pictures.push_back(
          {file, length(all[i], "width", at), length(all[i], "height", at), {}});
    }
    if (out_.pictures.empty())
      refuse("the annotation file has no pictures", "\"images\": []", "one picture or more",
             "--truth FILE, with another annotation file");
  }

  void read_annotations() {
    std::set<int64_t> ids;
    const Json& all = list("annotations");
    for (size_t i = 0; i < all.size(); ++i) {
      const Json& entry = all[i];
      std::string at = place("annotations", i);
      if (entry.is_object() && entry.contains("id")) {
        const int64_t id = integer(entry, "id", at);
        at += ", id " + std::to_string(id);
        if (!ids.insert(id).second)
          refuse("two annotations have the same id", at, "a unique id for each annotation",
                 "delete one of them");
      }
      const int64_t picture_id = integer(entry, "image_id", at);
      const auto picture = picture_of_.find(picture_id);
      if (picture == picture_of_.end())
        refuse("an annotation refers to a picture that is not in the list",
               at + ", image_id " + std::to_string(picture_id), "an id of \"images\"",
               "add the picture, or delete the annotation");
      read_annotation(entry, at, &out_.pictures[picture->second]);
    }
  }

  void read_annotation(const Json& entry, const std::string& at, CocoPicture* picture) {
    TruthObject object;
    const int64_t id = integer(entry, "category_id", at);
    const auto category = category_of_.find(id);
    if (category == category_of_.end())
      refuse("an annotation has a category that is not in the list",
             at + ", category_id " + std::to_string(id), "an id of \"categories\"",
             "add the category, or correct category_id");
    object.category = category->second;
    if (!entry.contains("bbox"))
      refuse("an annotation has no box", at, "\"bbox\": [x, y, width, height]",
             "add it to the entry");
    object.box = parse_box(entry, at, *picture);
    object.area = entry.contains("area") && entry["area"].is_number() ? entry["area"].get<double>()
                                                                      : object.box.area();
    if (!std::isfinite(object.area) || object.area < 0)
      refuse("the area of an annotation is not valid", at + ", " + entry["area"].dump(),
             "\"area\": pixels of the object, 0 or more", "correct it, or leave it out");
    object.is_crowd = is_set(entry, "iscrowd", at);
    object.is_ignored = object.is_crowd || is_set(entry, "ignore", at);
    if (entry.contains("keypoints")) read_points(entry, at, &object);
    picture->objects.push_back(std::move(object));
  }

  bool is_set(const Json& entry, const char* key, const std::string& at) const {
    if (!entry.contains(key)) return false;
    const Json& value = entry[key];
    if (value == 0 || value == 1 || value.is_boolean()) return value == 1 || value == true;
    refuse("an annotation has a flag that is neither 0 nor 1", at + ", " + key + " " + value.dump(),
           std::string("\"") + key + "\": 0 or 1", "correct it");
  }

  Rectangle parse_box(const Json& entry, const std::string& at, const CocoPicture& picture) {
    const auto n = numbers(entry["bbox"], 4, at + ", bbox");
    const Rectangle box{n[0], n[1], n[2], n[3]};
    const std::string offered = at + ", bbox " + entry["bbox"].dump();
    if (!(box.width > 0 && box.height > 0) || !std::isfinite(box.area()))
      refuse("a box has no area", offered, "[x, y, width, height] with a width and height above 0",
             "correct the box, or delete the annotation");
    if (picture.width == 0 || picture.height == 0) return box;
    const double right = box.x + box.width, bottom = box.y + box.height;
    const std::string size = std::to_string(picture.width) + " x " + std::to_string(picture.height);
    if (right <= 0 || bottom <= 0 || box.x >= picture.width || box.y >= picture.height)
      refuse("a box is outside of its picture",
             offered + " in " + picture.file + " of " + size + " pixels",
             "a box that overlaps the picture", "correct the box, or delete the annotation");
    constexpr double kRounding = 1;  // tools round edges
    if (box.x < -kRounding || box.y < -kRounding || right > picture.width + kRounding ||
        bottom > picture.height + kRounding) {
      if (boxes_over_edge_++ == 0) first_over_edge_ = offered + " in a picture of " + size;
    }
    return box;
  }

  void read_points(const Json& entry, const std::string& at, TruthObject* object) {
    const Json& list = entry["keypoints"];
    const size_t points = list.is_array() ? list.size() / 3 : 0;
    if (out_.key_points == 0) out_.key_points = points;
    if (points == 0 || points != out_.key_points)
      refuse("annotations have different numbers of key points",
             at + ": " + std::to_string(points) + " points",
             std::to_string(out_.key_points) + " points, as the annotations before it",
             "correct the entry, or put its category into another file");
    const auto n = numbers(list, 3 * points, at + ", keypoints");
    int64_t labelled = 0;
    for (size_t p = 0; p < points; ++p) {
      object->points.push_back({n[3 * p], n[3 * p + 1], n[3 * p + 2] > 0});
      labelled += object->points.back().is_labelled;
    }
    if (entry.contains("num_keypoints") && integer(entry, "num_keypoints", at) != labelled)
      refuse("an annotation contradicts itself",
             at + ": num_keypoints is " + entry["num_keypoints"].dump() + ", but " +
                 std::to_string(labelled) + " of its key points have a visibility above 0",
             "the number of labelled key points", "correct num_keypoints");
  }

  void warn_about_edges() {
    if (boxes_over_edge_ == 0) return;
    const bool is_one = boxes_over_edge_ == 1;
    out_.warnings.push_back(
        {.code = Code::LABELS_INVALID,
         .what =
             std::to_string(boxes_over_edge_) + (is_one ? " box reaches outside of its picture"
                                                        : " boxes reach outside of their pictures"),
         .offered = path_ + ": " + first_over_edge_,
         .needed = "boxes that end at the edge of the picture",
         .fix = "clip the boxes at the edge of the picture; Weir compares them unchanged"});
  }

  const std::string& path_;
  const Json& root_;
  CocoTruth out_;
  std::map<int64_t, size_t> category_of_, picture_of_;
  size_t boxes_over_edge_ = 0;
  std::string first_over_edge_;
};

Error not_json(const std::string& path, std::string_view text, size_t byte,
               const std::string& why) {
  Error out{.code = Code::LABELS_INVALID,
            .what = "the annotation file is not JSON",
            .offered = path,
            .needed = "a COCO annotation file",
            .difference = why};
  if (byte > 0) out.difference = place_in(text, std::min(byte - 1, text.size()));
  out.fix = "python3 -m json.tool FILE shows what is wrong; --truth FILE uses another file";
  return out;
}

}  // namespace

Result<CocoTruth> parse_coco_truth(const std::string& path, std::string_view text) {
  if (json_depth(text) > kDepthLimit)
    return Error{
        .code = Code::LABELS_INVALID,
        .what = "the annotation file is nested too deeply",
        .offered = path,
        .needed = "at most " + std::to_string(kDepthLimit) + " lists and objects in each other",
        .fix = "--truth FILE uses another file"};
  try {
    const Json root = Json::parse(text);
    return Reader(path, root).read();
  } catch (const Json::parse_error& error) {
    return not_json(path, text, error.byte, "");
  } catch (const Json::out_of_range&) {  // 1e999
    return not_json(path, text, 0, "a number is too large");
  } catch (const Refused& refused) {
    return refused.error;
  }
}

}  // namespace weir::evaluate
