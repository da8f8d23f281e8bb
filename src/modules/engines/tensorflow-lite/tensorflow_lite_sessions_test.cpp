// Tests sessions of one TensorFlow Lite model: concurrent, and each with its own state.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "engine_contract_test_support.hpp"
#include "tensorflow-lite/tflite_builder_test_support.hpp"

namespace weir::engine_test {
namespace tensorflow_lite_sessions_test {

class TensorflowLiteSessions : public EngineTest {};

TEST_F(TensorflowLiteSessions, SessionsOfOneModelRunConcurrently) {
  const auto path = folder_.write("model.tflite", tflite_negation({-1}).bytes());
  expect_threads_to_run_at_once(path);
}

TEST_F(TensorflowLiteSessions, ReportMissingMemoryAndRecover) {
  const auto path = folder_.write("model.tflite", tflite_negation({-1}).bytes());
  expect_errors_without_memory({*engine(), path, {1 << 22}, folder_.path("")});
}

// x + state, where the state kept by an SVDF is its last inputs.
TfliteBuilder summing() {
  const auto svdf_options = FlatValue::table({{0, FlatValue::scalar(int32_t{1})}});
  return TfliteBuilder()
      .input("x", kTfFloat, {1, 1})
      .constant<float>("features", kTfFloat, {1, 1}, {1})
      .constant<float>("time", kTfFloat, {1, 3}, {1, 1, 1})
      .variable("state", kTfFloat, {1, 3})
      .output("y", kTfFloat, {1, 1})
      .node(kOpSvdf, {"x", "features", "time", "", "state"}, {"y"})
      .options(6, svdf_options);
}

TEST_F(TensorflowLiteSessions, StateLastsUntilItIsReset) {
  auto model = open(summing().bytes());
  ASSERT_TRUE(model) << model.error().message();
  EXPECT_NE((*model)->info().flags & WEIR_MODEL_STATEFUL, 0u);
  const auto run = [&](float x) {
    const auto y = (*model)->invoke({make_tensor<float>(WEIR_FLOAT32, {1, 1}, {x})});
    return y ? (*y)[0].values<float>()[0] : -1;
  };
  EXPECT_EQ(run(1), 1);
  EXPECT_EQ(run(2), 3);
  EXPECT_EQ(run(4), 7);
  EXPECT_EQ(run(8), 14);  // the first has left the window
  EXPECT_TRUE((*model)->control(WEIR_RESET_STATE));
  EXPECT_EQ(run(1), 1);
  EXPECT_TRUE((*model)->control(WEIR_WARM));  // does not change the state
  EXPECT_EQ(run(1), 1);
}

// The first session takes the interpreter created when the model was opened; the others create
// theirs.
TEST_F(TensorflowLiteSessions, SessionsHaveTheirOwnState) {
  const auto path = folder_.write("model.tflite", summing().bytes());
  const char* const paths[] = {path.c_str()};
  weir_open request{};
  request.struct_size = sizeof request;
  request.n_models = 1;
  request.paths = paths;
  weir_error error{};
  weir_model* model = nullptr;
  ASSERT_EQ(engine()->open(&request, &model, &error), 0);
  std::vector<weir_session*> sessions(3);
  for (auto& session : sessions)
    ASSERT_EQ(engine()->session_new(model, nullptr, 0, &session, &error), 0);
  const auto run = [&](weir_session* session, float x) {
    auto in = make_tensor<float>(WEIR_FLOAT32, {1, 1}, {x});
    float y = -1;
    weir_tensor tensors[2] = {};
    for (auto& tensor : tensors) {
      tensor.info = in.info;
      tensor.bytes = tensor.capacity = sizeof y;
      tensor.fence_fd = -1;
    }
    tensors[0].data = in.bytes.data();
    tensors[1].data = &y;
    weir_frame frames[2] = {};
    for (int i = 0; i < 2; ++i) {
      frames[i].struct_size = sizeof frames[i];
      frames[i].n_tensors = 1;
      frames[i].tensors = &tensors[i];
      frames[i].pts = frames[i].duration = frames[i].deadline = -1;
    }
    EXPECT_EQ(engine()->invoke(session, &frames[0], &frames[1], &error), 0);
    return y;
  };
  EXPECT_EQ(run(sessions[0], 1), 1);
  EXPECT_EQ(run(sessions[1], 10), 10);
  EXPECT_EQ(run(sessions[0], 2), 3);
  EXPECT_EQ(run(sessions[2], 100), 100);
  EXPECT_EQ(run(sessions[1], 20), 30);
  for (auto* session : sessions) engine()->session_free(session);
  weir_session* later = nullptr;
  ASSERT_EQ(engine()->session_new(model, nullptr, 0, &later, &error), 0);
  EXPECT_EQ(run(later, 5), 5) << "and none of a session that is gone";
  engine()->session_free(later);
  engine()->close(model);
}

}  // namespace tensorflow_lite_sessions_test
}  // namespace weir::engine_test
