// What those who watch the health of models get.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "net/server/model_list.hpp"
#include "net/server/test_call.hpp"
#include "says.hpp"

namespace weir::net {
namespace model_list_test {

// Messages of the health service.
const std::string kServing = "\x08\x01", kNotServing = "\x08\x02", kUnknown = "\x08\x03";

class Watching : public ::testing::Test {
 protected:
  void watch(Ended* ended, const std::string& service) {
    list_->watch(std::make_shared<TestCall>(ended, ""), service);
  }
  static void describe(ServedModel* model) {
    model->set_inputs({{"x", "FP32", {1}}});
    model->set_outputs({{"y", "FP32", {1}}});
  }
  static std::shared_ptr<ServedModel> make(const std::string& name) {
    return std::make_shared<ServedModel>(ModelRequest{name, "1"}, "weir", 2);
  }

  const std::shared_ptr<ModelList> list_ = std::make_shared<ModelList>();
  const std::shared_ptr<ServedModel> model_ = make("m"), other_ = make("o");
};

TEST_F(Watching, SendsTheHealthNowAndEachChange) {
  Ended whole, model, other;
  ASSERT_TRUE(list_->add(model_, "here"));
  watch(&whole, "");
  watch(&model, "m");
  watch(&other, "o");
  describe(model_.get());
  ASSERT_TRUE(list_->add(other_, "here"));
  describe(other_.get());
  model_->close();
  using Sent = std::vector<std::string>;
  EXPECT_EQ(whole.sent, (Sent{kNotServing, kServing, kNotServing, kServing, kNotServing}));
  EXPECT_EQ(model.sent, (Sent{kNotServing, kServing, kNotServing}));
  EXPECT_EQ(other.sent, (Sent{kUnknown, kNotServing, kServing}));
  list_->remove(*other_);
  EXPECT_EQ(other.sent.back(), kNotServing);
  EXPECT_EQ(other.times, 0);
}

TEST_F(Watching, RemembersModelsThatMayComeBack) {
  ASSERT_TRUE(list_->add(model_, "here"));
  EXPECT_FALSE(list_->was_here({"m", ""}));
  list_->remove(*model_);
  list_->remove(*model_);
  EXPECT_TRUE(list_->was_here({"m", ""}));
  EXPECT_TRUE(list_->was_here({"m", "1"}));
  EXPECT_FALSE(list_->was_here({"m", "2"}));
  EXPECT_FALSE(list_->was_here({"o", ""}));
  EXPECT_EQ(list_->health("m"), Health::NotServing);
  EXPECT_EQ(list_->find({"m", ""}), nullptr);
  ASSERT_TRUE(list_->add(model_, "here"));
  EXPECT_FALSE(list_->was_here({"m", ""}));
}

TEST_F(Watching, TheWholeServesOnlyWhileAllItsModelsDo) {
  Ended whole;
  watch(&whole, "");
  for (const auto& model : {model_, other_}) {
    describe(model.get());
    ASSERT_TRUE(list_->add(model, "here"));
  }
  list_->remove(*other_);
  EXPECT_EQ(list_->health("m"), Health::Serving);
  ASSERT_TRUE(list_->add(other_, "here"));
  list_->remove(*model_);
  list_->remove(*other_);
  using Sent = std::vector<std::string>;
  EXPECT_EQ(whole.sent, (Sent{kNotServing, kServing, kNotServing, kServing, kNotServing}));
  EXPECT_EQ(list_->health("inference.GRPCInferenceService"), Health::NotServing);
}

TEST_F(Watching, AnotherVersionTakesThePlaceOfOneThatIsGone) {
  const auto next = std::make_shared<ServedModel>(ModelRequest{"m", "2"}, "weir", 2);
  for (const auto& model : {model_, next}) {
    describe(model.get());
    ASSERT_TRUE(list_->add(model, "here"));
  }
  list_->remove(*model_);
  EXPECT_EQ(list_->health(""), Health::Serving);
  EXPECT_EQ(list_->health("m"), Health::Serving);
}

TEST_F(Watching, EndsWithNotServing) {
  Ended before, after;
  ASSERT_TRUE(list_->add(model_, "here"));
  describe(model_.get());
  watch(&before, "m");
  list_->close();
  watch(&after, "m");
  EXPECT_EQ(before.sent, (std::vector<std::string>{kServing, kNotServing}));
  EXPECT_EQ(after.sent, (std::vector<std::string>{kNotServing}));
  for (const auto* ended : {&before, &after}) {
    EXPECT_EQ(ended->times, 1);
    EXPECT_EQ(ended->status, static_cast<int>(CallStatus::Unavailable));
    EXPECT_EQ(ended->text, "the server is stopping");
  }
}

TEST_F(Watching, ForgetsCallsThatEnded) {
  Ended ended, next;
  const auto call = std::make_shared<TestCall>(&ended, "");
  ASSERT_TRUE(list_->add(model_, "here"));
  list_->watch(call, "m");
  EXPECT_EQ(call.use_count(), 2);
  call->fail(CallStatus::Cancelled, "");
  watch(&next, "m");
  EXPECT_EQ(call.use_count(), 1);
  describe(model_.get());
  EXPECT_EQ(ended.sent.size(), 1u);
}

TEST_F(Watching, ModelsOfOneNameAreAnError) {
  ASSERT_TRUE(list_->add(model_, "here"));
  const auto status = list_->add(make("m"), "localhost:1");
  ASSERT_FALSE(status);
  EXPECT_SAYS(status.error().message(), "offered: m version 1 on localhost:1");
  EXPECT_EQ(list_->all().size(), 1u);
}

}  // namespace model_list_test
}  // namespace weir::net
