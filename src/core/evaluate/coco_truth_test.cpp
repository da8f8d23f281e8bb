// Annotation files of COCO: what is read and what is refused.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/coco_truth.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "says.hpp"

namespace weir::evaluate {
namespace coco_truth_test {

using Json = nlohmann::json;

Json example() {
  return Json::parse(R"({
    "categories": [{"id": 7, "name": "dog"}, {"id": 3, "name": "cat"}],
    "images": [{"id": 10, "file_name": "a.jpg", "width": 100, "height": 50},
               {"id": 11, "file_name": "b.jpg"}],
    "annotations": [{"id": 1, "image_id": 10, "category_id": 7, "bbox": [1, 2, 30, 40], "area": 900},
                    {"id": 2, "image_id": 11, "category_id": 3, "bbox": [0, 0, 5, 6], "iscrowd": 1}]})");
}

Result<CocoTruth> read(const Json& json) {
  return parse_coco_truth("truth.json", json.dump());
}
std::string refused(const Json& json) {
  const auto truth = read(json);
  return truth ? "it was read" : truth.error().message();
}

TEST(CocoTruth, HasCategoriesByRisingId) {
  const auto truth = read(example());
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->categories, (std::vector<std::string>{"cat", "dog"}));
  ASSERT_EQ(truth->pictures.size(), 2U);
  EXPECT_EQ(truth->pictures[0].file, "a.jpg");
  EXPECT_EQ(truth->pictures[0].width, 100U);
  EXPECT_EQ(truth->pictures[1].width, 0U);
  const TruthObject& dog = truth->pictures[0].objects.at(0);
  EXPECT_EQ(dog.category, 1U);
  EXPECT_EQ(dog.box, (Rectangle{1, 2, 30, 40}));
  EXPECT_EQ(dog.area, 900);
  EXPECT_FALSE(dog.is_crowd);
  const TruthObject& cat = truth->pictures[1].objects.at(0);
  EXPECT_TRUE(cat.is_crowd && cat.is_ignored);
  EXPECT_EQ(cat.area, 30);  // of the box, without an area
  EXPECT_TRUE(truth->warnings.empty());
  EXPECT_EQ(truth->key_points, 0U);
}

TEST(CocoTruth, HasKeyPoints) {
  Json json = example();
  json["annotations"][0]["keypoints"] = {1, 2, 2, 3, 4, 1, 0, 0, 0};
  json["annotations"][0]["num_keypoints"] = 2;
  const auto truth = read(json);
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->key_points, 3U);
  const auto& points = truth->pictures[0].objects[0].points;
  ASSERT_EQ(points.size(), 3U);
  EXPECT_EQ(points[1].x, 3);
  EXPECT_TRUE(points[1].is_labelled);
  EXPECT_FALSE(points[2].is_labelled);
}

TEST(CocoTruth, WarnsAboutBoxesOverTheEdge) {
  Json json = example();
  json["annotations"][0]["bbox"] = {90, 2, 30, 40};
  const auto truth = read(json);
  ASSERT_TRUE(truth);
  ASSERT_EQ(truth->warnings.size(), 1U);
  EXPECT_SAYS(truth->warnings[0].message(), "1 box reaches outside of its picture");
  EXPECT_SAYS(truth->warnings[0].message(), "truth.json: annotations[0], id 1, bbox [90,2,30,40]");
}

TEST(CocoTruthRefused, TextThatIsNotJson) {
  const auto truth = parse_coco_truth("truth.json", R"({"images": [})");
  ASSERT_FALSE(truth);
  EXPECT_EQ(truth.error().code, Code::LABELS_INVALID);
  EXPECT_SAYS(truth.error().message(), "the annotation file is not JSON");
  EXPECT_SAYS(truth.error().message(), "at character 13:");
  EXPECT_SAYS(truth.error().message(), "offered: truth.json");
  EXPECT_FALSE(parse_coco_truth("truth.json", ""));
}

TEST(CocoTruthRefused, NumbersThatAreNotFinite) {
  const auto text = [](const std::string& number) {
    std::string json = example().dump();
    return json.replace(json.find("900"), 3, number);
  };
  EXPECT_SAYS(parse_coco_truth("t", text("1e999")).error().message(), "a number is too large");
  EXPECT_SAYS(parse_coco_truth("t", text("NaN")).error().message(), "is not JSON");
  EXPECT_SAYS(parse_coco_truth("t", text("-1")).error().message(),
              "the area of an annotation is not valid");
}

TEST(CocoTruthRefused, FilesThatAreNoAnnotations) {
  EXPECT_SAYS(refused(Json::array()), "not a COCO annotation file");
  for (const char* name : {"images", "annotations", "categories"}) {
    Json json = example();
    json.erase(name);
    EXPECT_SAYS(refused(json), "no list \"" + std::string(name) + "\"");
  }
  for (const char* name : {"images", "categories"}) {
    Json json = example();
    json[name] = Json::array();
    json["annotations"] = Json::array();
    EXPECT_SAYS(refused(json), "the annotation file has no ");
  }
}

TEST(CocoTruthRefused, IdsThatOccurTwice) {
  Json json = example();
  json["images"][1]["id"] = 10;
  EXPECT_SAYS(refused(json), "two pictures have the same id");
  EXPECT_SAYS(refused(json), "images[1], id 10");
  json = example();
  json["categories"][1]["id"] = 7;
  EXPECT_SAYS(refused(json), "two categories have the same id");
  json = example();
  json["annotations"][1]["id"] = 1;
  EXPECT_SAYS(refused(json), "two annotations have the same id");
  EXPECT_SAYS(refused(json), "fix: delete one of them");
}

TEST(CocoTruthRefused, NamesThatOccurTwice) {
  Json json = example();
  json["images"][1]["file_name"] = "a.jpg";
  EXPECT_SAYS(refused(json), "a picture is listed twice");
  json = example();
  json["categories"][1]["name"] = "dog";
  EXPECT_SAYS(refused(json), "two categories have the same name");
}

TEST(CocoTruthRefused, AnnotationsOfNothing) {
  Json json = example();
  json["annotations"][0]["image_id"] = 99;
  EXPECT_SAYS(refused(json), "refers to a picture that is not in the list");
  EXPECT_SAYS(refused(json), "annotations[0], id 1, image_id 99");
  json = example();
  json["annotations"][0]["category_id"] = 99;
  EXPECT_SAYS(refused(json), "a category that is not in the list");
}

TEST(CocoTruthRefused, BoxesThatCannotBe) {
  const auto with = [](const Json& box) {
    Json json = example();
    json["annotations"][0]["bbox"] = box;
    return refused(json);
  };
  EXPECT_SAYS(with({100, 2, 3, 4}), "a box is outside of its picture");
  EXPECT_SAYS(with({100, 2, 3, 4}), "in a.jpg of 100 x 50 pixels");
  EXPECT_SAYS(with({-9, 2, 3, 4}), "a box is outside of its picture");
  EXPECT_SAYS(with({1, 2, 0, 4}), "a box has no area");
  EXPECT_SAYS(with({1, 2, 3, -4}), "a box has no area");
  EXPECT_SAYS(with({1, 2, 1e200, 1e200}), "a box has no area");
  EXPECT_SAYS(with({1, 2, 3}), "4 finite numbers");
  EXPECT_SAYS(with({1, 2, 3, nullptr}), "4 finite numbers");
  EXPECT_SAYS(with("1,2,3,4"), "4 finite numbers");
  Json json = example();
  json["annotations"][0].erase("bbox");
  EXPECT_SAYS(refused(json), "an annotation has no box");
}

TEST(CocoTruthRefused, KeyPointsThatDoNotFit) {
  Json json = example();
  json["annotations"][0]["keypoints"] = {1, 2, 2, 3, 4, 1};
  json["annotations"][0]["num_keypoints"] = 1;
  EXPECT_SAYS(refused(json), "num_keypoints is 1, but 2 of its key points");
  json["annotations"][0]["num_keypoints"] = 2;
  json["annotations"][1]["keypoints"] = {1, 2, 2};
  EXPECT_SAYS(refused(json), "different numbers of key points");
  json["annotations"][1]["keypoints"] = {1, 2, 2, 3, 4, 1, 5};
  EXPECT_SAYS(refused(json), "6 finite numbers");
}

TEST(CocoTruthRefused, EntriesThatLackSomething) {
  for (const auto& [list, key] : {std::pair{"images", "id"},
                                  {"images", "file_name"},
                                  {"categories", "id"},
                                  {"categories", "name"},
                                  {"annotations", "image_id"},
                                  {"annotations", "category_id"}}) {
    Json json = example();
    json[list][0].erase(key);
    EXPECT_SAYS(refused(json), "\"" + std::string(key) + "\"");
    EXPECT_SAYS(refused(json), std::string(list) + "[0]");
    json[list][0] = 5;
    EXPECT_SAYS(refused(json), std::string(list) + "[0]");
  }
  Json json = example();
  json["images"][0]["width"] = 0;
  EXPECT_SAYS(refused(json), "the size of a picture is not valid");
  json = example();
  json["annotations"][0]["iscrowd"] = 2;
  EXPECT_SAYS(refused(json), "neither 0 nor 1");
}

// Printing, copying and comparing a value would exhaust the stack.
TEST(CocoTruth, RefusesTextThatIsNestedTooDeeply) {
  const auto with_flag = [](const std::string& flag) {
    std::string text = example().dump();
    const std::string place = "\"iscrowd\":1";
    text.replace(text.find(place), place.size(), "\"iscrowd\":" + flag);
    const auto truth = parse_coco_truth("truth.json", text);
    return truth ? std::string() : truth.error().message();
  };
  const auto nested = [](size_t depth) {
    return std::string(depth, '[') + std::string(depth, ']');
  };
  EXPECT_SAYS(with_flag(nested(300000)), "the annotation file is nested too deeply");
  EXPECT_SAYS(with_flag(nested(62)), "the annotation file is nested too deeply");
  EXPECT_SAYS(with_flag(nested(61)), "a flag that is neither 0 nor 1");
}

}  // namespace coco_truth_test
}  // namespace weir::evaluate
