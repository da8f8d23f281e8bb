// GTensorFilterSingle: its properties and the functions of its class.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensor_filter_single.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <memory>
#include <string>
#include <vector>

#include "nnstreamer_plugin_api_util.h"
#include "tensor_filter_custom_easy.h"

namespace filter_single_test {

int doubles(void*, const GstTensorFilterProperties*, const GstTensorMemory* in,
            GstTensorMemory* out) {
  for (size_t i = 0; i < in[0].size; ++i)
    static_cast<uint8_t*>(out[0].data)[i] =
        static_cast<uint8_t>(2 * static_cast<const uint8_t*>(in[0].data)[i]);
  return 0;
}

class FilterSingle : public testing::Test {
 protected:
  FilterSingle() {
    gst_tensors_info_init(&info_);
    info_.num_tensors = gst_tensors_info_parse_dimensions_string(&info_, "3:1");
    gst_tensors_info_parse_types_string(&info_, "uint8");
    EXPECT_EQ(NNS_custom_easy_register("doubles", doubles, nullptr, &info_, &info_), 0);
  }
  ~FilterSingle() override {
    g_object_unref(single);
    EXPECT_EQ(NNS_custom_easy_unregister("doubles"), 0);
    gst_tensors_info_free(&info_);
  }
  void use(const char* framework, const char* model) {
    g_object_set(single, "framework", framework, "model", model, nullptr);
  }
  std::string text(const char* property) const {
    gchar* read = nullptr;
    g_object_get(single, property, &read, nullptr);
    const std::unique_ptr<gchar, decltype(&g_free)> owned(read, g_free);
    return read ? read : "NULL";
  }

  GTensorFilterSingle* single =
      G_TENSOR_FILTER_SINGLE(g_object_new(G_TYPE_TENSOR_FILTER_SINGLE, nullptr));
  GTensorFilterSingleClass* klass = G_TENSOR_FILTER_SINGLE_GET_CLASS(single);
  uint8_t numbers_[3] = {1, 2, 3};
  uint8_t place_[3] = {};
  const GstTensorMemory in_{numbers_, sizeof numbers_};
  GstTensorsInfo info_;
};

TEST_F(FilterSingle, HasThePropertiesOfTheElement) {
  guint count = 0;
  g_free(g_object_class_list_properties(G_OBJECT_CLASS(klass), &count));
  EXPECT_EQ(count, 27u);
  EXPECT_STREQ(G_OBJECT_TYPE_NAME(single), "GTensorFilterSingle");
  use("custom-easy", "doubles");
  EXPECT_EQ(text("framework"), "custom-easy");
  EXPECT_EQ(text("input"), "") << "not started";
  gboolean silent = FALSE;
  gint latency = 0;
  g_object_get(single, "silent", &silent, "latency", &latency, nullptr);
  EXPECT_TRUE(silent);
  EXPECT_EQ(latency, -1);
  ASSERT_TRUE(klass->start(single));
  EXPECT_TRUE(klass->start(single)) << "started already";
  EXPECT_EQ(text("input"), "3:1");
  EXPECT_EQ(text("outputtype"), "uint8");
  EXPECT_EQ(text("inputranks"), "2");
  EXPECT_EQ(text("inputlayout"), "ANY");
}

TEST_F(FilterSingle, InvokesIntoTheCallersMemory) {
  use("custom-easy", "doubles");
  GstTensorMemory out{place_, sizeof place_};
  ASSERT_TRUE(klass->invoke(single, &in_, &out, FALSE)) << "it starts automatically";
  EXPECT_EQ(place_[2], 6);
  EXPECT_TRUE(klass->input_configured(single) && klass->output_configured(single));
  EXPECT_FALSE(klass->allocate_in_invoke(single));
}

TEST_F(FilterSingle, AllocatesWhatTheCallerFrees) {
  use("custom-easy", "doubles");
  ASSERT_TRUE(klass->start(single));
  GstTensorMemory out{nullptr, 3};
  ASSERT_TRUE(klass->invoke(single, &in_, &out, TRUE));
  EXPECT_EQ(static_cast<uint8_t*>(out.data)[0], 2);
  klass->destroy_notify(single, &out);
  EXPECT_EQ(out.data, nullptr);
  for (const size_t size : {0, 2}) {
    GstTensorMemory wrong{nullptr, size};
    EXPECT_FALSE(klass->invoke(single, &in_, &wrong, TRUE)) << size;
  }
}

TEST_F(FilterSingle, RefusesWhatCannotRun) {
  GstTensorMemory out{place_, sizeof place_};
  EXPECT_FALSE(klass->input_configured(single));
  EXPECT_EQ(klass->set_input_info(single, &info_, &info_), -EINVAL) << "not started";
  use("no-such-framework", "doubles");
  EXPECT_FALSE(klass->start(single));
  EXPECT_FALSE(klass->invoke(single, &in_, &out, FALSE));
  use("custom-easy", "nothing");
  EXPECT_FALSE(klass->start(single));
  use("custom-easy", "doubles");
  EXPECT_FALSE(klass->invoke(single, nullptr, &out, FALSE));
  EXPECT_FALSE(klass->invoke(single, &in_, nullptr, FALSE));
  const GstTensorMemory small{numbers_, 2};
  EXPECT_FALSE(klass->invoke(single, &small, &out, FALSE));
  ASSERT_TRUE(klass->start(single));
  GstTensorsInfo other, made;
  gst_tensors_info_init(&other);
  other.num_tensors = gst_tensors_info_parse_dimensions_string(&other, "4");
  gst_tensors_info_parse_types_string(&other, "uint8");
  EXPECT_EQ(klass->set_input_info(single, &other, &made), -ENOENT) << "its shape is fixed";
  gst_tensors_info_free(&other);
  EXPECT_TRUE(klass->stop(single));
  EXPECT_FALSE(klass->output_configured(single));
}

int add(GstTensorMemory* data, GstTensorsInfo* info, void* sum) {
  for (size_t i = 0; i < data[0].size; ++i)
    *static_cast<int*>(sum) += static_cast<uint8_t*>(data[0].data)[i];
  return info->num_tensors == 1 ? 0 : -1;
}

TEST_F(FilterSingle, CallsBackWithInvokeAsync) {
  use("custom-easy", "doubles");
  g_object_set(single, "invoke-async", TRUE, nullptr);
  EXPECT_FALSE(klass->start(single)) << "no callback";
  int sum = 0;
  EXPECT_TRUE(klass->set_invoke_async_callback(single, add, &sum));
  GstTensorMemory out{place_, sizeof place_};
  ASSERT_TRUE(klass->invoke(single, &in_, &out, FALSE));
  EXPECT_EQ(sum, 12);
}

}  // namespace filter_single_test
