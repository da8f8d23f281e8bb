// Tests models and sessions with faulty engines: each fault is an error, not a crash.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/model/model.hpp"

#include <gtest/gtest.h>

#include <climits>
#include <filesystem>
#include <fstream>

#include "core/infer/module/engine_objects_test_support.hpp"
#include "says.hpp"

namespace weir::infer {
namespace model_test {

weir_model the_model{};
weir_session the_session{};
weir_model_info the_info{};
int open_result, info_result, session_result, invoke_result, closed, freed;
bool gives_model, gives_session;

weir_engine engine() {
  weir_engine e{};
  e.struct_size = sizeof e;
  e.name = "test";
  e.open = [](const weir_open*, weir_model** out, weir_error*) {
    if (gives_model) *out = &the_model;
    return open_result;
  };
  e.close = [](weir_model*) { ++closed; };
  e.info = [](weir_model*, weir_model_info* out, weir_error*) {
    *out = the_info;
    return info_result;
  };
  e.session_new = [](weir_model*, const weir_option*, uint32_t, weir_session** out, weir_error*) {
    if (gives_session) *out = &the_session;
    return session_result;
  };
  e.session_free = [](weir_session*) { ++freed; };
  e.invoke = [](weir_session*, const weir_frame*, weir_frame*, weir_error*) {
    return invoke_result;
  };
  return e;
}

class ModelTest : public ::testing::Test {
 protected:
  void SetUp() override {
    open_result = info_result = session_result = invoke_result = closed = freed = 0;
    gives_model = gives_session = true;
    the_info = {};
    tensor_ = {};
    tensor_.type = WEIR_FLOAT32;
    tensor_.rank = 1;
    tensor_.shape[0] = 4;
    tensor_.name = "x";
    the_info.struct_size = sizeof the_info;
    the_info.n_inputs = the_info.n_outputs = 1;
    the_info.inputs = the_info.outputs = &tensor_;
  }
  std::string open_error() {
    const auto model = Model::open(engine_, {});
    return model ? "" : model.error().message();
  }

  weir_engine engine_ = engine();
  weir_tensor_info tensor_{};
};

TEST_F(ModelTest, DescribesAndCloses) {
  {
    const auto model = Model::open(engine_, {});
    ASSERT_TRUE(model);
    ASSERT_EQ((*model)->inputs().size(), 1u);
    EXPECT_STREQ((*model)->inputs()[0].name, "x");
    const auto session = Session::create(*model);
    ASSERT_TRUE(session);
    weir_frame in{}, out{};
    EXPECT_TRUE(*(*session)->invoke(in, out));
    invoke_result = 1;
    EXPECT_FALSE(*(*session)->invoke(in, out)) << "1: the frame is dropped";
    invoke_result = -WEIR_INVOKE_FAILED;
    EXPECT_FALSE((*session)->invoke(in, out));
  }
  EXPECT_EQ(closed, 1);
  EXPECT_EQ(freed, 1);
}

TEST_F(ModelTest, LooksForTheFileFirst) {
  const std::string folder = testing::TempDir() + "weir-model-test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder + "/mobilenet.onnx") << "x";
  OpenOptions options;
  options.paths = {folder + "/mobilnet.onnx"};
  auto model = Model::open(engine_, options);
  ASSERT_FALSE(model);
  EXPECT_EQ(model.error().code, Code::MODEL_NOT_FOUND);
  EXPECT_SAYS(model.error().message(), "did you mean mobilenet.onnx?");
  options.paths = {folder};
  model = Model::open(engine_, options);
  ASSERT_FALSE(model);
  EXPECT_SAYS(model.error().message(), "the model is a folder");
  std::filesystem::remove_all(folder);
}

TEST_F(ModelTest, RejectsAnEngineThatGivesNoModel) {
  gives_model = false;
  EXPECT_SAYS(open_error(), "the model cannot be opened");
  open_result = INT_MIN;
  EXPECT_SAYS(open_error(), "the model cannot be opened");
  EXPECT_EQ(closed, 0);
}

TEST_F(ModelTest, RejectsADescriptionThatFails) {
  info_result = -WEIR_MODEL_INVALID;
  EXPECT_SAYS(open_error(), "cannot describe the model");
  EXPECT_EQ(closed, 1) << "the model is closed all the same";
}

TEST_F(ModelTest, RejectsDescriptionsBeyondTheLimits) {
  the_info.n_inputs = UINT32_MAX;
  EXPECT_SAYS(open_error(), "too many tensors");
  the_info.n_inputs = 1;
  the_info.inputs = nullptr;
  EXPECT_SAYS(open_error(), "without descriptions");
  the_info.inputs = &tensor_;
  tensor_.rank = 17;
  EXPECT_SAYS(open_error(), "beyond the limits");
  tensor_.rank = 1;
  tensor_.type = 99;
  EXPECT_SAYS(open_error(), "beyond the limits");
}

TEST_F(ModelTest, RejectsAnEngineThatGivesNoSession) {
  const auto model = Model::open(engine_, {});
  ASSERT_TRUE(model);
  gives_session = false;
  auto session = Session::create(*model);
  ASSERT_FALSE(session);
  EXPECT_SAYS(session.error().message(), "no session could be created");
  session_result = -WEIR_OUT_OF_MEMORY;
  session = Session::create(*model);
  ASSERT_FALSE(session);
  EXPECT_EQ(session.error().code, Code::OUT_OF_MEMORY);
}

}  // namespace model_test
}  // namespace weir::infer
