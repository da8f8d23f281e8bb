// Tests of filters registered by a program and by libraries: NNS_custom_easy_*, tensor_filter_cpp.
// This program links with libnnstreamer.so, as users' programs do.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "filter_lines_test_support.hpp"
#include "nnstreamer_plugin_api_util.h"
#include "tensor_filter_cpp.hh"
#include "tensor_filter_custom_easy.h"

namespace program_test {

using namespace weir::test;

class Info {
 public:
  Info(const char* dimensions, const char* types) {
    gst_tensors_info_init(&info_);
    info_.num_tensors = gst_tensors_info_parse_dimensions_string(&info_, dimensions);
    gst_tensors_info_parse_types_string(&info_, types);
  }
  ~Info() { gst_tensors_info_free(&info_); }
  Info(const Info&) = delete;
  Info& operator=(const Info&) = delete;
  GstTensorsInfo* get() { return &info_; }

 private:
  GstTensorsInfo info_;
};

struct Easy {
  explicit Easy(const char* given) : name(given) {}
  ~Easy() { NNS_custom_easy_unregister(name); }
  Easy(const Easy&) = delete;
  Easy& operator=(const Easy&) = delete;
  const char* name;
};

int add(void* data, const GstTensorFilterProperties* prop, const GstTensorMemory* in,
        GstTensorMemory* out) {
  if (prop->num_models != 1 || std::strcmp(prop->model_files[0], "adder") != 0) return -1;
  const auto* x = static_cast<const uint8_t*>(in[0].data);
  if (x[0] == 100) return 1;
  if (x[0] == 101) return -EIO;
  if (x[0] == 102) throw std::runtime_error("no such number");
  for (size_t i = 0; i < out[0].size; ++i)
    static_cast<uint8_t*>(out[0].data)[i] = static_cast<uint8_t>(x[i] + *static_cast<int*>(data));
  return 0;
}

// As many bytes as the first value; for 9 two tensors, for 17 seventeen.
int grow(void*, const GstTensorsInfo* in_info, GstTensorsInfo* out_info, const GstTensorMemory* in,
         GstTensorMemory* out) {
  if (in_info->num_tensors != 1) return -1;
  const uint8_t count = *static_cast<const uint8_t*>(in[0].data);
  out_info->num_tensors = count == 9 ? 2 : count == 17 ? 17 : 1;
  for (unsigned i = 0; i < out_info->num_tensors; ++i) {
    auto* info = gst_tensors_info_get_nth_info(out_info, i);
    info->type = _NNS_UINT8;
    info->dimension[0] = count;
    out[i].data = std::malloc(count);
    out[i].size = count;
    std::memset(out[i].data, count, count);
  }
  return 0;
}

const std::string kLine = "tensor_filter framework=custom-easy model=adder";
const std::string kTwo = tensors("uint8", "2");

TEST(CompatProgram, FunctionIsAFilter) {
  int number = 5;
  Info two("2", "uint8");
  ASSERT_EQ(NNS_custom_easy_register("adder", add, &number, two.get(), two.get()), 0);
  const Easy adder("adder");
  auto h = make_harness(kLine, kTwo);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{6, 7}));
  EXPECT_EQ(pushed<uint8_t>(h, {100, 2}), Bytes{}) << "dropped";
  EXPECT_SAYS(frame_error<uint8_t>(h, {101, 2}), "-5 (Input/output error)");
  h = make_harness(kLine, kTwo);
  EXPECT_SAYS(frame_error<uint8_t>(h, {102, 2}), "threw an exception in its function");
}

class Flexible : public Info {
 public:
  explicit Flexible(unsigned count) : Info("", "") {
    get()->num_tensors = count;
    get()->format = _NNS_TENSOR_FORMAT_FLEXIBLE;
  }
};

TEST(CompatProgram, FunctionAcceptsADeclaredNumberOfTensors) {
  int number = 5;
  Flexible one(1);
  ASSERT_EQ(NNS_custom_easy_register("adder", add, &number, one.get(), one.get()), 0);
  const Easy adder("adder");
  auto h = make_harness(kLine, kTwo);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{6, 7}));
  EXPECT_SAYS(caps_text(h), "dimension=(string)2,");
  h = make_harness(kLine, tensors("uint8", "3"));
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2, 3}), (Bytes{6, 7, 8}));
  EXPECT_SAYS(start_error(kLine,
                          "other/tensors,format=static,num_tensors=2,dimensions=(string)3.3,"
                          "types=(string)uint8.uint8,framerate=30/1"),
              "number of tensors");
}

TEST(CompatProgram, FilterReportsTheTensorsOfAFunction) {
  int number = 5;
  Info three("2,3:4,1", "uint8,int16,float32"), two("2,3", "uint8,uint8");
  ASSERT_EQ(NNS_custom_easy_register("adder", add, &number, three.get(), two.get()), 0);
  const Easy adder("adder");
  const auto filter = lone_element(kLine);
  const auto reported = [&](const char* property) {
    gchar* raw = nullptr;
    g_object_get(filter.get(), property, &raw, nullptr);
    const weir::gst::UniqueText text{raw};
    return std::string(raw ? raw : "NULL");
  };
  EXPECT_EQ(reported("input"), "2,3:4,1");
  EXPECT_EQ(reported("inputtype"), "uint8,int16,float32");
  EXPECT_EQ(reported("inputname"), ",,") << "three tensors without names";
  EXPECT_EQ(reported("inputranks"), "1,2,1");
  EXPECT_EQ(reported("inputlayout"), "ANY,ANY,ANY");
  EXPECT_EQ(reported("output"), "2,3");
  EXPECT_EQ(reported("outputname"), ",");
}

TEST(CompatProgram, FunctionDecidesSizesForAnyInput) {
  Flexible one(1);
  ASSERT_EQ(NNS_custom_easy_dynamic_register("grower", grow, nullptr, one.get()), 0);
  const Easy grower("grower");
  auto h = make_harness("tensor_filter framework=custom-easy model=grower invoke-dynamic=true",
                        tensors("uint8", "2"));
  EXPECT_EQ(pushed<uint8_t>(h, {3, 0}).size(), 128u + 3);
}

TEST(CompatProgram, FunctionNeedsANumberOfTensors) {
  int number = 5;
  Flexible none(0), one(1), many(257);
  EXPECT_EQ(NNS_custom_easy_register("adder", add, &number, none.get(), one.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_register("adder", add, &number, one.get(), none.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_register("adder", add, &number, many.get(), one.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_dynamic_register("grower", grow, nullptr, none.get()), -EINVAL);
  Flexible two(2);
  ASSERT_EQ(NNS_custom_easy_register("adder", add, &number, one.get(), two.get()), 0);
  const Easy adder("adder");
  EXPECT_SAYS(start_error(kLine, kTwo), "rejects the inputs of the stream");
}

TEST(CompatProgram, FunctionDecidesSizes) {
  Info one("1", "uint8");
  ASSERT_EQ(NNS_custom_easy_dynamic_register("grower", grow, nullptr, one.get()), 0);
  const Easy grower("grower");
  const std::string line = "tensor_filter framework=custom-easy model=grower ";
  auto h = make_harness(line + "invoke-dynamic=true", tensors("uint8", "1"));
  for (const uint8_t count : {uint8_t{3}, uint8_t{1}}) {
    const auto out = pushed<uint8_t>(h, {count});
    ASSERT_EQ(out.size(), 128u + count);
    EXPECT_EQ(out.back(), count);
  }
  ASSERT_EQ(gst_harness_push(h.get(), frame<uint8_t>({9})), GST_FLOW_OK);
  const auto two = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  EXPECT_EQ(gst_buffer_n_memory(two.get()), 2u);
  EXPECT_EQ(content(two.get()).size(), 2 * (128u + 9));
  const auto message = frame_error<uint8_t>(h, {17});
  EXPECT_SAYS(message, "returned more outputs than expected\n  offered: 17\n  needed: at most 16");
  EXPECT_SAYS(start_error(line), "invoke-dynamic=true");
}

TEST(CompatProgram, NamesAndDescriptionsAreChecked) {
  Info two("2", "uint8"), none("0", "uint8");
  EXPECT_EQ(NNS_custom_easy_register("adder", add, nullptr, two.get(), two.get()), 0);
  const Easy adder("adder");
  EXPECT_EQ(NNS_custom_easy_register("adder", add, nullptr, two.get(), two.get()), -EINVAL);
  for (const char* name : {"any", "AUTO", "", "a,b"})
    EXPECT_EQ(NNS_custom_easy_register(name, add, nullptr, two.get(), two.get()), -EINVAL) << name;
  EXPECT_EQ(NNS_custom_easy_register(nullptr, add, nullptr, two.get(), two.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_register("x", nullptr, nullptr, two.get(), two.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_register("x", add, nullptr, none.get(), two.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_register("x", add, nullptr, two.get(), nullptr), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_dynamic_register("x", nullptr, nullptr, two.get()), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_unregister("x"), -EINVAL);
  EXPECT_EQ(NNS_custom_easy_unregister(nullptr), -EINVAL);
  EXPECT_SAYS(start_error("tensor_filter framework=custom-easy model=x"), "one of: adder");
}

TEST(CompatProgram, LibraryProvidesTheFunction) {
  auto h = make_harness("tensor_filter framework=custom-easy model=easy", kTwo);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 255}), (Bytes{2, 0}));
}

TEST(CompatProgram, LibraryProvidesObjects) {
  const std::string library = "," + filter_file("object");
  auto h =
      make_harness("tensor_filter framework=cpp model=negated" + library, tensors("int8", "3"));
  EXPECT_EQ(pushed<int8_t>(h, {1, -2, 3}), (std::vector<int8_t>{-1, 2, -3}));
  h = make_harness("tensor_filter framework=cpp model=counted", tensors("float32", "5"));
  EXPECT_EQ((pushed<float, uint8_t>(h, {9, 9, 9, 9, 9})), (Bytes{0, 1, 2, 3, 4}));
}

class Object : public tensor_filter_cpp {
 public:
  explicit Object(const char* name) : tensor_filter_cpp(name) {}
  int getInputDim(GstTensorsInfo* info) override {
    info->num_tensors = 1;
    info->info[0].type = _NNS_UINT8;
    info->info[0].dimension[0] = 2;
    return 0;
  }
  int getOutputDim(GstTensorsInfo* info) override { return getInputDim(info); }
  int setInputDim(const GstTensorsInfo*, GstTensorsInfo*) override { return -1; }
  int invoke(const GstTensorMemory* in, GstTensorMemory* out) override {
    if (*static_cast<const uint8_t*>(in[0].data) == 0) throw std::runtime_error("nothing");
    std::memcpy(out[0].data, in[0].data, 2);
    custom_ = prop->custom_properties ? prop->custom_properties : "";
    return 0;
  }
  bool isAllocatedBeforeInvoke() override { return true; }
  bool is_open() const { return prop != nullptr; }
  std::string custom_;
};
static_assert(sizeof(void*) != 8 || sizeof(tensor_filter_cpp) == 40, "as NNStreamer's");

TEST(CompatProgram, ObjectIsAFilter) {
  Object object("object"), same("object"), reserved("Any");
  ASSERT_EQ(object._register(), 0);
  EXPECT_EQ(object._register(), -EINVAL);
  EXPECT_EQ(same._register(), -EINVAL);
  EXPECT_EQ(reserved._register(), -EINVAL);
  EXPECT_EQ(tensor_filter_cpp::__register(nullptr), -EINVAL);
  {
    auto h = make_harness("tensor_filter framework=cpp model=object", kTwo);
    EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{1, 2}));
    EXPECT_SAYS(frame_error<uint8_t>(h, {0, 2}), "the filter object threw an exception in invoke");
  }
  EXPECT_EQ(object._unregister(), 0);
  EXPECT_EQ(object._unregister(), -EINVAL);
  EXPECT_SAYS(start_error("tensor_filter framework=cpp model=object"),
              "no filter class has this name");
}

TEST(CompatProgram, ObjectHasThePropertiesOfTheElementThatOpenedItLast) {
  Object object("with-properties");
  EXPECT_TRUE(object.isValid());
  ASSERT_EQ(object._register(3), 0);
  EXPECT_FALSE(object.is_open());
  {
    auto h = make_harness("tensor_filter framework=cpp model=with-properties custom=speed:2", kTwo);
    EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{1, 2}));
    EXPECT_EQ(object.custom_, "speed:2");
    auto other = make_harness("tensor_filter framework=cpp model=with-properties custom=a:b", kTwo);
    EXPECT_EQ(pushed<uint8_t>(other, {1, 2}), (Bytes{1, 2}));
    EXPECT_EQ(object.custom_, "a:b");
    other = nullptr;
    EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{1, 2}));
    EXPECT_EQ(object.custom_, "speed:2") << "of the one that is still open";
  }
  EXPECT_FALSE(object.is_open());
}

TEST(CompatProgram, ObjectCanBeDestroyedBeforeItsElementCloses) {
  auto object = std::make_unique<Object>("early");
  ASSERT_EQ(object->_register(), 0);
  auto h = make_harness("tensor_filter framework=cpp model=early", kTwo);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{1, 2}));
  EXPECT_EQ(object->_unregister(), 0);
  object.reset();
  h = nullptr;
}

TEST(CompatProgram, ObjectThatIsDestroyedWhileItIsUsedEndsTheStream) {
  auto object = std::make_unique<Object>("gone");
  ASSERT_EQ(object->_register(), 0);
  auto h = make_harness("tensor_filter framework=cpp model=gone", kTwo);
  EXPECT_EQ(pushed<uint8_t>(h, {1, 2}), (Bytes{1, 2}));
  object.reset();
  EXPECT_SAYS(frame_error<uint8_t>(h, {1, 2}), "the filter object is no longer registered");
}

TEST(CompatProgram, DestroyedObjectIsUnregistered) {
  {
    Object object("short");
    ASSERT_EQ(object._register(), 0);
  }
  Object again("short");
  EXPECT_EQ(again._register(), 0);
}

}  // namespace program_test
