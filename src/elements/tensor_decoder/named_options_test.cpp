// The properties threshold, iou, labels, max-results, classes and custom of tensor_decoder.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>

#include "elements/tensor_decoder/result_test_support.hpp"
#include "elements/tests/tuning_test_support.hpp"

namespace weir::testing_tensor_decoder {
namespace named_options_test {

const std::string kHead = "custom=head:yolov8,input:32:32";
const std::string kFirst = "1:0.9@14,5,18,11^-1", kSecond = "0:0.5@6,19,14,21^-1";

Tuned detector(const std::string& properties) {
  return {"tensor_decoder", "tensor_decoder mode=detection " + properties, kYoloCaps};
}
Rows rows(Tuned& t) {
  if (gst_harness_push(t.harness.get(), frame(yolo(kTwo))) != GST_FLOW_OK) return {"failed"};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(t.harness.get()));
  return out ? read_rows(t.harness, out.get()) : Rows{"nothing"};
}
std::string file(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "weir-" + name;
  std::ofstream(path) << text;
  return path;
}

TEST(NamedOptions, AreUnsetAtFirst) {
  Tuned t("tensor_decoder", "tensor_decoder mode=octet_stream", "");
  EXPECT_EQ(t.get("threshold"), "-1");
  EXPECT_EQ(t.get("iou"), "-1");
  EXPECT_EQ(t.get("max-results"), "0");
  for (const char* name : {"labels", "classes", "custom"}) EXPECT_EQ(t.get(name), "NULL") << name;
}

TEST(NamedOptions, ReachTheDecoder) {
  const auto labels = file("three-labels.txt", "disc\nsquare\nstar\n");
  const auto with = [&](const std::string& properties) {
    auto t = detector(kHead + " " + properties);
    const auto out = rows(t);
    EXPECT_EQ(t.messages.next_warning(), "") << properties;
    return out;
  };
  EXPECT_EQ(with(""), (Rows{kFirst, kSecond}));
  EXPECT_EQ(with("threshold=0.6"), (Rows{kFirst}));
  EXPECT_EQ(with("threshold=0"), with("threshold=0.0"));
  EXPECT_EQ(with("max-results=1"), (Rows{kFirst}));
  EXPECT_EQ(with("classes=0"), (Rows{kSecond}));
  EXPECT_EQ(with("labels=" + labels + " classes=square,star"), (Rows{kFirst}));
  EXPECT_EQ(with("iou=0.3"), (Rows{kFirst, kSecond}));
}

TEST(NamedOptions, MayChangeBetweenFrames) {
  auto t = detector(kHead);
  EXPECT_EQ(rows(t), (Rows{kFirst, kSecond}));
  t.set("threshold", "0.6");
  EXPECT_EQ(rows(t), (Rows{kFirst}));
  t.set("threshold", "-1");
  t.set("classes", "0");
  EXPECT_EQ(rows(t), (Rows{kSecond}));
  t.set("custom", "head:yolov8,input:32:32,name:a:b");
  EXPECT_EQ(rows(t), (Rows{kSecond}));
  EXPECT_SAYS(t.caps(), "weir-source=(string)a:b") << "a value may contain colons";
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(NamedOptions, ThatCannotBeUsedWhilePlayingReadBackAsBefore) {
  auto t = detector(kHead);
  EXPECT_EQ(rows(t), (Rows{kFirst, kSecond}));
  t.set("classes", "circle");
  EXPECT_EQ(rows(t), (Rows{kFirst, kSecond}));
  EXPECT_SAYS(t.messages.next_warning(), "a class is neither a label nor a number");
  EXPECT_EQ(t.get("classes"), "NULL");
  t.set("custom", "head");
  EXPECT_EQ(rows(t), (Rows{kFirst, kSecond}));
  EXPECT_SAYS(t.messages.next_warning(), "custom is not a list of options");
  EXPECT_EQ(t.get("custom"), "head:yolov8,input:32:32");
  EXPECT_EQ(t.messages.next(), "");
}

TEST(NamedOptions, ThatTheModeDoesNotUseAreWarnings) {
  const auto warning = [](const std::string& properties) {
    const auto element = lone_element("tensor_decoder " + properties);
    Errors messages(element.get());
    gst_element_set_state(element.get(), GST_STATE_PAUSED);
    const std::string first = messages.next_warning();
    EXPECT_EQ(messages.next(), "") << properties;
    gst_element_set_state(element.get(), GST_STATE_NULL);
    return first;
  };
  const std::string labels = file("one-label.txt", "one\n");
  EXPECT_EQ(warning("mode=image_labeling option1=" + labels), "");
  const std::string of_threshold = warning("mode=image_labeling threshold=0.5 option1=" + labels);
  EXPECT_SAYS(of_threshold, "WEIR-1004: the mode does not use this option, so it has no effect");
  EXPECT_SAYS(of_threshold, "offered: threshold=0.5 with mode=image_labeling");
  EXPECT_SAYS(of_threshold, "needed: one of: option1");
  EXPECT_SAYS(warning("mode=octet_stream max-results=3"), "takes none");
  EXPECT_SAYS(warning("mode=octet_stream iou=0.5"), "iou=0.5 with mode=octet_stream");
  EXPECT_SAYS(warning("mode=octet_stream labels=a.txt"), "labels=a.txt");
  EXPECT_SAYS(warning("mode=octet_stream classes=1"), "classes=1");
  EXPECT_SAYS(warning("mode=detection threshold=0.4 custom=threshold:0.9"),
              "an option is set twice; the first value counts");
}

TEST(NamedOptions, OfCustomMustBeKnown) {
  const std::string error = get_error("mode=detection custom=name:a,haed:yolov8,input:32:32");
  EXPECT_SAYS(error, "WEIR-1004: the mode has no such option");
  EXPECT_SAYS(error, "offered: custom=haed:yolov8 with mode=detection");
  EXPECT_SAYS(error, "needed: one of: threshold, iou, labels, max-results, classes, head, input");
  EXPECT_SAYS(error, "did you mean head?");
  EXPECT_SAYS(error, "fix: tensor_decoder mode=detection custom=name:a,head:yolov8,input:32:32");
  const std::string of_none = get_error("mode=octet_stream custom=head:yolov8");
  EXPECT_SAYS(of_none, "needed: no option: mode=octet_stream takes none");
  EXPECT_SAYS(of_none, "fix: tensor_decoder mode=octet_stream");
  EXPECT_SAYS(get_error("mode=json custom=maskz:rle"), "did you mean masks?");
  const std::string of_head =
      get_error("mode=detection custom=head:yolov8,scales:1/1/1/1,unit:pixels");
  EXPECT_SAYS(of_head, "the head yolov8 does not read this setting") << "before the caps";
  EXPECT_SAYS(of_head, "needed: one of: head, input, name, unit\n");
  EXPECT_SAYS(get_error("mode=detection custom=head:yolov8,untt:pixels"),
              "fix: tensor_decoder mode=detection custom=head:yolov8,unit:pixels");
  auto t = detector(kHead);
  t.set("custom", "head:yolov8,input:32:32,scores:logits");
  EXPECT_EQ(rows(t), (Rows{kFirst, kSecond}));
  EXPECT_SAYS(t.messages.next_warning(), "the head yolov8 does not read this setting");
  EXPECT_EQ(t.get("custom"), "head:yolov8,input:32:32");
}

TEST(NamedOptions, OfOneOptionCustomMustHaveAValue) {
  for (const char* custom : {"head", ":yolov8", "head:yolov8,input"}) {
    const std::string error = get_error("mode=detection custom=" + std::string(custom));
    EXPECT_SAYS(error, "WEIR-1001: custom is not a list of options") << custom;
    EXPECT_SAYS(error, "needed: key:value for each option, separated by commas");
    EXPECT_SAYS(error, "fix: custom=head:yolov8");
  }
  EXPECT_EQ(get_error("mode=octet_stream custom=,", tensor("uint8", "1"), {1}), "");
}

TEST(NamedOptions, MayComeFromAFile) {
  const auto path =
      file("decoder.conf", "threshold=0.6\nmax-results=5\ncustom=head:yolov8,input:32:32\n");
  auto t = detector("config-file=" + path);
  EXPECT_EQ(rows(t), (Rows{kFirst}));
  EXPECT_EQ(t.messages.next_warning(), "");
}

TEST(NamedOptions, AFileThatCannotBeReadIsRejectedWhileFramesFlow) {
  const auto path = file("decoder.conf", "max-results=5\nmax-resluts=6\n");
  auto t = detector("config-file=" + path);
  t.set("config-file", "/nowhere/decoder.conf");
  EXPECT_SAYS(t.messages.next_warning(), "WEIR-4001: the property file cannot be read");
  EXPECT_EQ(t.get("config-file"), path);
  t.set("config-file", path.c_str());
  EXPECT_SAYS(t.messages.next_warning(), "did you mean max-results?");
  EXPECT_EQ(t.messages.next_warning(), "");
}

}  // namespace named_options_test
}  // namespace weir::testing_tensor_decoder
