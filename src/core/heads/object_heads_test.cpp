// Tests of detectors that give a set of objects (end-to-end YOLO, DETR, RT-DETR), of SSD,
// FastestDet and NanoDet, on tensors encoded from their published descriptions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <filesystem>
#include <fstream>

#include "core/heads/head_test_support.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {
namespace object_heads_test {

const std::vector<TestObject> kObjects{{4, 8, 20, 40, 0.9f, 2}, {30, 30, 62, 50, 0.6f, 0}};

TEST(EndToEndHeads, RowsAreObjectsInPixelsOrParts) {
  for (const float unit : {1.0f, 1.0f / 64}) {
    Floats version10, version7, output;
    for (const auto& [x1, y1, x2, y2, score, index] : kObjects) {
      const auto c = static_cast<float>(index);
      for (const float number : {x1 * unit, y1 * unit, x2 * unit, y2 * unit, score, c})
        version10.push_back(number);
      for (const float number : {0.0f, x1 * unit, y1 * unit, x2 * unit, y2 * unit, c, score})
        version7.push_back(number);
      for (const float number : {0.0f, c, score, x1 * unit, y1 * unit, x2 * unit, y2 * unit})
        output.push_back(number);
    }
    // A row below the threshold; the end of the rows; a row after the end.
    version10.insert(version10.end(), {0, 0, 9, 9, 0.1f, 1});
    version7.insert(version7.end(), {0, 0, 0, 9, 9, 1, 0.1f});
    output.insert(output.end(), {-1, 0, 0, 0, 0, 0, 0, 0, 1, 0.9f, 1, 1, 5, 5});
    expect_found(run_head({TestOutput("6:3:1", version10)}).found, kObjects);
    expect_found(run_head({TestOutput("7:3:1", version7)}, {.head = "yolov7-end2end"}).found,
                 kObjects);
    expect_found(run_head({TestOutput("7:4:1", output)}, {.head = "detection-output"}).found,
                 kObjects);
  }
}

TEST(EndToEndHeads, ClassesOfQuantisedRowsAreTheNearestWholeNumbers) {
  for (const float index : {0.996f, 1.004f}) {
    const auto found =
        run_head({TestOutput("6:1:1", {1, 2, 30, 40, 0.9f, index})}, {.head = "yolov10"}).found;
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].class_index, 1);
  }
  EXPECT_EQ(run_head({TestOutput("6:1:1", {1, 2, 30, 40, 0.9f, -0.6f})}, {.head = "yolov10"})
                .found.size(),
            0u);
}

TEST(EndToEndHeads, NeedTheInputSizeForPartsOfThePictureOnly) {
  const HeadSetup unknown{.head = "yolov10", .input = {}};
  EXPECT_EQ(run_head({TestOutput("6:1:1", {1, 2, 30, 40, 0.9f, 1})}, unknown).found.size(), 1u);
  EXPECT_SAYS(run_head({TestOutput("6:1:1", {0, 0, 0.5f, 0.5f, 0.9f, 1})}, unknown).error,
              "custom=input:640:640");
}

TEST(EndToEndHeads, WarnOfCoordinatesThatContradictTheUnit) {
  const auto read = [](const Floats& rows, const char* unit) {
    HeadSetup setup{.head = "yolov10"};
    if (unit) setup.custom = {{"unit", unit}};
    return run_head({TestOutput(shape_text(6, rows.size() / 6).c_str(), rows)}, setup);
  };
  const Floats pixels{1, 2, 30, 40, 0.9f, 1, 5, 5, 61, 60, 0.8f, 1};
  const Floats parts{0.1f, 0.2f, 0.5f, 0.75f, 0.9f, 1};
  EXPECT_EQ(read(pixels, "pixels").warning, "");
  EXPECT_EQ(read(parts, "picture").warning, "");
  EXPECT_EQ(read(pixels, nullptr).warning, "");
  const auto as_parts = read(pixels, "picture").warning;
  EXPECT_SAYS(as_parts, "the coordinates contradict the setting unit");
  EXPECT_SAYS(as_parts, "coordinates up to 61 of 2 boxes");
  EXPECT_SAYS(as_parts, "custom=unit:pixels");
  EXPECT_EQ(read(parts, "pixels").warning, "") << "one box may be that small";
  Floats many;
  for (int i = 0; i < 20; ++i) many.insert(many.end(), parts.begin(), parts.end());
  EXPECT_EQ(read(Floats(many.begin() + 6, many.end()), "pixels").warning, "") << "19 boxes";
  const auto as_pixels = read(many, "pixels").warning;
  EXPECT_SAYS(as_pixels, "coordinates up to 0.75 of 20 boxes");
  EXPECT_SAYS(as_pixels, "custom=unit:picture");
}

TEST(EndToEndHeads, OneBoxFarBeyondThePictureDoesNotDecideTheUnit) {
  Floats rows;
  for (const auto& [x1, y1, x2, y2, score, index] : kObjects)
    for (const float number :
         {x1 / 64, y1 / 64, x2 / 64, y2 / 64, score, static_cast<float>(index)})
      rows.push_back(number);
  rows.insert(rows.end(), {0, 0, 2.5f, 0.5f, 0.3f, 1});
  const auto result = run_head({TestOutput("6:3:1", rows)}, {.head = "yolov10"});
  ASSERT_EQ(result.found.size(), 3u);
  EXPECT_FLOAT_EQ(result.found[0].width, 16);
  EXPECT_FLOAT_EQ(result.found[2].width, 160);
}

TEST(EndToEndHeads, AModelHasOneUnitInAllFrames) {
  const ModelSignature facts = facts_of({TestOutput("6:3:1", {})}, {});
  const auto head = kYolov10.open(facts, {.threshold = 0.25f});
  const auto read = [&](const Floats& rows) {
    const TestOutput output("6:3:1", rows);
    const std::vector<weir_tensor> tensors{output.tensor()};
    OutputValues values;
    values.begin(tensors);
    return head->find(values, {64, 64});
  };
  const Floats large{8, 8, 40, 40, 0.9f, 0, 9, 30, 50, 50, 0.8f, 0, 1, 2, 60, 61, 0.7f, 0};
  const Floats small{0, 0, 1.5f, 2, 0.9f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_FLOAT_EQ(read(large).at(0).width, 32);
  EXPECT_FLOAT_EQ(read(small).at(0).width, 1.5f) << "a box in the first two pixels";
}

TEST(EndToEndHeads, LeaveOutRowsThatAreNotFinite) {
  for (size_t value = 0; value < 6; ++value)
    for (const float number : {float(NAN), INFINITY, -INFINITY}) {
      Floats row{1, 2, 30, 40, 0.9f, 1};
      row[value] = number;
      EXPECT_EQ(run_head({TestOutput("6:1:1", row)}, {.head = "yolov10"}).found.size(), 0u);
    }
  EXPECT_EQ(
      run_head({TestOutput("6:1:1", {1, 2, 30, 40, 0.9f, -1})}, {.head = "yolov10"}).found.size(),
      0u);
}

// Queries of centre and size, 0 to 1, and logits of the probabilities of a softmax or a sigmoid.
struct Queries {
  Floats boxes, logits, probabilities;
};
Queries encode_queries(size_t count, size_t classes, bool has_no_object) {
  Queries out;
  const size_t length = classes + (has_no_object ? 1 : 0);
  for (size_t i = 0; i < count; ++i) {
    const auto object = i < kObjects.size() ? kObjects[i] : TestObject{0, 0, 9, 9, 0, 0};
    for (const float number : {(object.x1 + object.x2) / 128, (object.y1 + object.y2) / 128,
                               (object.x2 - object.x1) / 64, (object.y2 - object.y1) / 64})
      out.boxes.push_back(number);
    Floats row(length, 0.01f);
    if (object.score > 0) row[static_cast<size_t>(object.class_index)] = object.score;
    if (has_no_object) {  // probabilities of a softmax sum to 1
      float rest = 1;
      for (size_t c = 0; c < classes; ++c) rest -= row[c];
      row[classes] = rest;
    }
    for (const float p : row) {
      out.logits.push_back(has_no_object ? std::log(p) + 3 : std::log(p / (1 - p)));
      out.probabilities.push_back(p);
    }
  }
  return out;
}

TEST(DetrHeads, SoftmaxLeavesOutTheClassOfNoObject) {
  const auto queries = encode_queries(100, 5, true);
  const TestOutput logits("6:100:1", queries.logits, "logits"),
      boxes("4:100:1", queries.boxes, "pred_boxes");
  for (const auto& outputs : {std::vector{logits, boxes}, std::vector{boxes, logits}}) {
    const auto result = run_head(outputs, {.labels = 5, .threshold = 0.5f});
    EXPECT_EQ(result.family, "detr") << result.error;
    expect_found(result.found, kObjects);
  }
}

TEST(DetrHeads, BoxesMayBeInPixels) {
  for (const char* head : {"detr", "rtdetr"}) {
    auto queries = encode_queries(100, 5, std::string(head) == "detr");
    for (float& number : queries.boxes) number *= 64;
    const std::string scores = head == std::string("detr") ? "6:100:1" : "5:100:1";
    const auto result = run_head({TestOutput(scores.c_str(), queries.logits, "logits"),
                                  TestOutput("4:100:1", queries.boxes, "pred_boxes")},
                                 {.head = head, .input = {}, .threshold = 0.5f});
    EXPECT_EQ(result.error, "") << "pixels need no input size";
    EXPECT_EQ(result.warning, "");
    expect_found(result.found, kObjects);
  }
}

TEST(DetrHeads, NamesDistinguishFourClassesFromBoxes) {
  const auto queries = encode_queries(100, 3, true);
  const TestOutput logits("4:100:1", queries.logits, "logits"),
      boxes("4:100:1", queries.boxes, "pred_boxes");
  expect_found(run_head({boxes, logits}, {.head = "detr", .threshold = 0.5f}).found, kObjects);
  expect_found(run_head({logits, boxes}, {.head = "detr", .threshold = 0.5f}).found, kObjects);
}

TEST(DetrHeads, RtDetrHasLogitsOrProbabilitiesAndOneOrTwoOutputs) {
  const auto queries = encode_queries(300, 5, false);
  for (const Floats& scores : {queries.logits, queries.probabilities}) {
    const auto two = run_head({TestOutput("5:300:1", scores), TestOutput("4:300:1", queries.boxes)},
                              {.labels = 5, .threshold = 0.5f});
    EXPECT_EQ(two.family, "rtdetr") << two.error;
    expect_found(two.found, kObjects);
    Floats joined;
    for (size_t i = 0; i < 300; ++i) {
      joined.insert(joined.end(), queries.boxes.begin() + long(4 * i),
                    queries.boxes.begin() + long(4 * i + 4));
      joined.insert(joined.end(), scores.begin() + long(5 * i), scores.begin() + long(5 * i + 5));
    }
    const auto one = run_head({TestOutput("9:300:1", joined)}, {.threshold = 0.5f});
    EXPECT_EQ(one.family, "rtdetr") << one.error;
    expect_found(one.found, kObjects);
  }
}

TEST(DetrHeads, LeaveOutWhatIsNotFinite) {
  for (const char* head : {"detr", "rtdetr"}) {
    Queries queries = encode_queries(100, 5, true);
    std::fill(queries.logits.begin(), queries.logits.end(), NAN);
    EXPECT_EQ(
        run_head({TestOutput("6:100:1", queries.logits), TestOutput("4:100:1", queries.boxes)},
                 {.head = head})
            .found.size(),
        0u);
    std::fill(queries.boxes.begin(), queries.boxes.end(), INFINITY);
    EXPECT_EQ(run_head({TestOutput("6:100:1", encode_queries(100, 5, true).logits),
                        TestOutput("4:100:1", queries.boxes)},
                       {.head = head})
                  .found.size(),
              0u);
  }
}

TEST(DetrHeads, LabelsBoxesScoresAreReadInAnyOrder) {
  const auto labels =
      TestOutput::of(ElementType::Int64, "2:1", std::vector<int64_t>{3, 1}, "labels");
  const TestOutput boxes("4:2:1", {4, 8, 20, 40, 30, 30, 62, 50}, "boxes");
  const TestOutput scores("2:1", {0.9f, 0.6f}, "scores");
  HeadSetup setup;
  setup.custom = {{"first-class", "1"}};
  for (const auto& outputs :
       {std::vector{labels, boxes, scores}, std::vector{scores, labels, boxes},
        std::vector{boxes, scores, labels}}) {
    const auto result = run_head(outputs, setup);
    EXPECT_EQ(result.family, "labels-boxes-scores") << result.error;
    expect_found(result.found, kObjects);
  }
  // Numbers of classes as floats are known by the names.
  const TestOutput float_labels("2:1", {3, 1}, "classes");
  expect_found(run_head({scores, float_labels, boxes}, setup).found, kObjects);
  setup.custom = {{"first-class", "one"}};
  EXPECT_SAYS(run_head({labels, boxes, scores}, setup).error, "custom=first-class:one");
}

// ---- SSD ----

struct Prior {
  float y, x, height, width;
};
// The anchors of SSD MobileNet of 300 x 300 pixels: 19, 10, 5, 3, 2 and 1 cells, in the loops of
// the paper.
std::vector<Prior> make_priors() {
  std::vector<Prior> out;
  for (const int grid : {0, 1, 2, 3, 4, 5}) {
    const int side = std::vector<int>{19, 10, 5, 3, 2, 1}[static_cast<size_t>(grid)];
    const double scale = 0.2 + 0.15 * grid, next = grid == 5 ? 1 : scale + 0.15;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const auto add = [&](double s, double ratio) {
          out.push_back({static_cast<float>((y + 0.5) / side), static_cast<float>((x + 0.5) / side),
                         static_cast<float>(s / std::sqrt(ratio)),
                         static_cast<float>(s * std::sqrt(ratio))});
        };
        if (grid == 0) {
          add(0.1, 1), add(0.2, 2), add(0.2, 0.5);
        } else {
          for (const double ratio : {1.0, 2.0, 0.5, 3.0, 1 / 3.0}) add(scale, ratio);
          add(std::sqrt(scale * next), 1);
        }
      }
  }
  return out;
}

struct SsdTensors {
  Floats boxes, logits;
};
SsdTensors encode_ssd(const std::vector<Prior>& priors, size_t classes, float side,
                      const std::vector<size_t>& anchors) {
  SsdTensors out{Floats(priors.size() * 4), Floats(priors.size() * classes, -5)};
  for (size_t i = 0; i < anchors.size(); ++i) {
    const size_t anchor = anchors[i];
    const auto& [x1, y1, x2, y2, score, index] = kObjects[i];
    const Prior& prior = priors[anchor];
    float* box = &out.boxes[4 * anchor];
    box[0] = ((y1 + y2) / 2 / side - prior.y) / prior.height * 10;
    box[1] = ((x1 + x2) / 2 / side - prior.x) / prior.width * 10;
    box[2] = std::log((y2 - y1) / side / prior.height) * 5;
    box[3] = std::log((x2 - x1) / side / prior.width) * 5;
    out.logits[anchor * classes + static_cast<size_t>(index) + 1] = std::log(score / (1 - score));
  }
  return out;
}

TEST(SsdHeads, AnchorsOfMobileNetAreMade) {
  const auto priors = make_priors();
  ASSERT_EQ(priors.size(), 1917u);
  const auto tensors = encode_ssd(priors, 6, 300, {100, 1900});
  const TestOutput boxes("4:1:1917:1", tensors.boxes), logits("6:1917:1", tensors.logits);
  for (const auto& outputs : {std::vector{boxes, logits}, std::vector{logits, boxes}}) {
    // Five labels: none for the background.
    const auto result = run_head(outputs, {.input = {300, 300}, .labels = 5, .threshold = 0.5f});
    EXPECT_EQ(result.family, "ssd") << result.error;
    expect_found(result.found, kObjects);
    // Six labels: the first is the background's.
    auto background = kObjects;
    for (auto& object : background) ++object.class_index;
    expect_found(run_head(outputs, {.input = {300, 300}, .labels = 6, .threshold = 0.5f}).found,
                 background);
  }
  Floats probabilities;
  for (const float logit : tensors.logits) probabilities.push_back(1 / (1 + std::exp(-logit)));
  expect_found(run_head({boxes, TestOutput("6:1917:1", probabilities)},
                        {.input = {}, .labels = 5, .threshold = 0.5f})
                   .found,
               kObjects, 0.02f);
}

TEST(SsdHeads, PriorsMayComeFromAFile) {
  const std::vector<Prior> priors{{0.5f, 0.5f, 0.3f, 0.2f}, {0.25f, 0.75f, 0.5f, 0.4f}};
  const std::string path = testing::TempDir() + "weir-heads-priors.txt";
  const auto write = [&](size_t count) {
    std::ofstream file(path);
    for (const float Prior::*column : {&Prior::y, &Prior::x, &Prior::height, &Prior::width}) {
      for (size_t i = 0; i < count; ++i) file << priors[i].*column << ' ';
      file << '\n';
    }
  };
  write(2);
  const auto tensors = encode_ssd(priors, 4, 64, {0, 1});
  const std::vector<TestOutput> outputs{TestOutput("4:2:1", tensors.boxes),
                                        TestOutput("4:2:1", tensors.logits)};
  HeadSetup setup{.head = "ssd", .labels = 3, .custom = {{"priors", path}}, .threshold = 0.5f};
  expect_found(run_head(outputs, setup).found, kObjects);
  write(1);
  EXPECT_SAYS(run_head(outputs, setup).error, "fewer prior boxes than the model has anchors");
  setup.custom["priors"] = "/nowhere/priors.txt";
  EXPECT_SAYS(run_head(outputs, setup).error, "/nowhere/priors.txt");
  std::ofstream(path) << "1 2\n3 x\n";
  setup.custom["priors"] = path;
  EXPECT_SAYS(run_head(outputs, setup).error, "custom=priors:" + path);
  setup.custom.clear();
  EXPECT_SAYS(run_head(outputs, setup).error, "custom=priors:/path/to/box_priors.txt");
  std::filesystem::remove(path);
}

TEST(SsdHeads, ScalesCanBeSet) {
  const auto tensors = encode_ssd(make_priors(), 6, 300, {100, 1900});
  HeadSetup setup{.input = {300, 300}, .labels = 5, .threshold = 0.5f};
  Floats doubled = tensors.boxes;
  for (float& number : doubled) number *= 2;
  setup.custom = {{"scales", "20/20/10/10"}};
  expect_found(
      run_head({TestOutput("4:1917:1", doubled), TestOutput("6:1917:1", tensors.logits)}, setup)
          .found,
      kObjects);
  for (const char* scales : {"10", "10/10/5/0", "a/b/c/d", "10/10/5/5/5"}) {
    setup.custom = {{"scales", scales}};
    EXPECT_SAYS(
        run_head({TestOutput("4:1917:1", doubled), TestOutput("6:1917:1", tensors.logits)}, setup)
            .error,
        std::string("custom=scales:") + scales);
  }
}

TEST(SsdHeads, PostprocessedOutputsAreReadInAnyOrder) {
  const float k = 1.0f / 64;
  Floats boxes;
  for (const auto& object : kObjects)
    boxes.insert(boxes.end(), {object.y1 * k, object.x1 * k, object.y2 * k, object.x2 * k});
  boxes.insert(boxes.end(), {0, 0, 1, 1});
  const auto named = [](const char* shape, const Floats& numbers, const char* name) {
    return TestOutput(shape, numbers, name);
  };
  // The layer's names in its own order.
  expect_found(run_head({named("4:3:1", boxes, "TFLite_Detection_PostProcess"),
                         named("3:1", {2, 0, 1}, "TFLite_Detection_PostProcess:1"),
                         named("3:1", {0.9f, 0.6f, 0.9f}, "TFLite_Detection_PostProcess:2"),
                         named("1:1", {2}, "TFLite_Detection_PostProcess:3")})
                   .found,
               kObjects);
  // No names: whole numbers are classes.
  const auto result = run_head({named("3:1", {0.9f, 0.6f, 0.9f}, ""), named("4:3:1", boxes, ""),
                                named("1:1", {2}, ""), named("3:1", {2, 0, 1}, "")});
  EXPECT_EQ(result.family, "ssd-postprocess") << result.error;
  expect_found(result.found, kObjects);
  // TensorFlow's names; classes count from 1.
  expect_found(
      run_head({named("4:3:1", boxes, "detection_boxes"),
                named("3:1", {3, 1, 2}, "detection_classes"), named("1:1", {2}, "num_detections"),
                named("3:1", {0.9f, 0.6f, 0.9f}, "detection_scores")})
          .found,
      kObjects);
}

TEST(SsdHeads, PostprocessedBoxesMayBeInPixelsAndEndWithThePicture) {
  const auto read = [](float unit) {
    Floats boxes;
    for (const auto& object : kObjects)
      for (const float edge : {object.y1, object.x1, object.y2, object.x2})
        boxes.push_back(edge * unit);
    boxes.insert(boxes.end(), {-8 * unit, 32 * unit, 16 * unit, 72 * unit});
    return run_head({TestOutput("4:3:1", boxes), TestOutput("3:1", {2, 0, 1}),
                     TestOutput("3:1", {0.9f, 0.6f, 0.55f}), TestOutput("1:1", {3})},
                    {.head = "ssd-postprocess", .threshold = 0.5f});
  };
  auto wanted = kObjects;
  wanted.push_back({32, 0, 64, 16, 0.55f, 1});
  for (const float unit : {1.0f, 1.0f / 64}) expect_found(read(unit).found, wanted);
}

TEST(SsdHeads, PostprocessedRowsThatAreNotFiniteAreLeftOut) {
  for (const float count : {0.0f, -1.0f, float(NAN)}) {
    const auto result = run_head({TestOutput("4:1", {0, 0, 1, 1}), TestOutput("1:1", {1}),
                                  TestOutput("1:1", {1}), TestOutput("1:1", {count})},
                                 {.head = "ssd-postprocess"});
    EXPECT_EQ(result.found.size(), 0u);
  }
  const auto found =
      run_head({TestOutput("4:2:1", {0, NAN, 1, 1, 0, 0, INFINITY, 1}), TestOutput("2:1", {1, 1}),
                TestOutput("2:1", {0.9f, 0.9f}), TestOutput("1:1", {1e30f})},
               {.head = "ssd-postprocess"})
          .found;
  EXPECT_EQ(found.size(), 0u);
}

// ---- FastestDet and NanoDet ----

TEST(GridDetectors, FastestDetGivesBoxesRelativeToItsCells) {
  constexpr size_t kClasses = 6, kLength = 5 + kClasses, kSide = 4;
  Floats rows(kSide * kSide * kLength, 0.01f);
  const size_t cells[] = {4, 11};  // near the centres 12, 24 and 46, 40
  for (size_t i = 0; i < 2; ++i) {
    const auto& object = kObjects[i];
    float* row = &rows[cells[i] * kLength];
    const float x = (object.x1 + object.x2) / 2 / 16, y = (object.y1 + object.y2) / 2 / 16;
    const auto inverse = [](float p) { return std::log(p / (1 - p)); };
    row[0] = object.score;
    row[1] = std::atanh(x - static_cast<float>(cells[i] % kSide));
    row[2] = std::atanh(y - static_cast<float>(cells[i] / kSide));
    row[3] = inverse((object.x2 - object.x1) / 64);
    row[4] = inverse((object.y2 - object.y1) / 64);
    row[5 + static_cast<size_t>(object.class_index)] = object.score;  // p^0.6 * p^0.4 = p
  }
  for (const Size input : {Size{64, 64}, {}}) {
    const TestOutput output("4:4:11:1", transposed(rows, kLength));
    const auto result = run_head({output}, {.input = input, .threshold = 0.5f});
    EXPECT_EQ(result.family, "fastestdet") << result.error;
    expect_found(result.found, kObjects);
  }
  const TestOutput bad("4:4:11:1", Floats(16 * 11, NAN));
  EXPECT_EQ(run_head({bad}).found.size(), 0u);
  rows[cells[0] * kLength + 3] = NAN;  // the width of the first object
  const TestOutput half("4:4:11:1", transposed(rows, kLength));
  expect_found(run_head({half}, {.threshold = 0.5f}).found, {kObjects[1]});
}

TEST(GridDetectors, NanoDetGivesDistributionsOfDistances) {
  constexpr size_t kClasses = 5, kLength = kClasses + 32, kCells = 84;
  Floats rows(kCells * kLength, 0.01f);
  // Cells of 32 pixels; their centres are 16, 16 and 48, 48.
  const size_t cells[] = {80, 83};
  const float centres[] = {16, 48};
  const std::vector<TestObject> objects{{4, 8, 20, 40, 0.9f, 2}, {30, 30, 62, 50, 0.6f, 0}};
  for (size_t i = 0; i < 2; ++i) {
    const auto& object = objects[i];
    float* row = &rows[cells[i] * kLength];
    row[object.class_index] = object.score;
    const float distances[] = {centres[i] - object.x1, centres[i] - object.y1,
                               object.x2 - centres[i], object.y2 - centres[i]};
    for (size_t edge = 0; edge < 4; ++edge) {
      // All weight is on the two bins around the distance.
      const float bin = distances[edge] / 32;
      const auto low = static_cast<size_t>(bin);
      float* logits = row + kClasses + 8 * edge;
      std::fill_n(logits, 8, -60.0f);
      logits[low] = std::log(1 - (bin - static_cast<float>(low)) + 1e-9f);
      logits[low + 1] = std::log(bin - static_cast<float>(low) + 1e-9f);
    }
  }
  for (const auto& output : both_orders(rows, kLength)) {
    const auto result = run_head({output}, {.head = "nanodet"});
    expect_found(result.found, objects, 2e-3f);
  }
  EXPECT_EQ(run_head({both_orders(Floats(kCells * kLength, NAN), kLength)[0]}, {.head = "nanodet"})
                .found.size(),
            0u);
}

TEST(ObjectHeads, RefuseOtherOutputs) {
  for (const char* head :
       {"yolov10", "yolov7-end2end", "detection-output", "detr", "rtdetr", "labels-boxes-scores",
        "ssd", "ssd-postprocess", "fastestdet", "nanodet"})
    EXPECT_SAYS(run_head({TestOutput("3:1", Floats(3))}, {.head = head}).error,
                std::string("the outputs are not those of the head ") + head);
}

TEST(Ultraface, WarnsOfOffsetsFromPriors) {
  constexpr size_t kPriors = 4420;
  const auto warning = [](const char* head, const Floats& box) {
    Floats boxes, scores(2 * kPriors, 0);
    for (size_t i = 0; i < kPriors; ++i) boxes.insert(boxes.end(), box.begin(), box.end());
    scores[2 * 100 + 1] = 0.9f;
    const auto result = run_head({TestOutput("2:4420:1", scores), TestOutput("4:4420:1", boxes)},
                                 {.head = head, .input = {320, 240}});
    EXPECT_EQ(result.error, "");
    return result.warning;
  };
  const Floats offsets{0.9f, -0.5f, -1.75f, 2.25f};
  EXPECT_SAYS(warning("ultraface", offsets), "offsets from prior boxes");
  EXPECT_SAYS(warning("ultraface", offsets), "custom=head:ultraface-raw");
  EXPECT_EQ(warning("ultraface-raw", offsets), "");
  EXPECT_EQ(warning("ultraface-raw", {0, 0, 30, 9}), "") << "it has no setting unit";
  EXPECT_EQ(warning("ultraface", {0.25f, 0.25f, 0.5f, 0.75f}), "");
  EXPECT_EQ(warning("ultraface", {-0.125f, 0.25f, 0.5f, 1.25f}), "");
}

}  // namespace object_heads_test
}  // namespace weir::heads
