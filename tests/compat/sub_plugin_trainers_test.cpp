// Tests of NNStreamer trainers: opened, checked and listed; no element runs them yet.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/process/process_object.hpp"
#include "core/subplugin/loader.hpp"
#include "library/process.h"
#include "nnstreamer_plugin_api_trainer.h"
#include "says.hpp"
#include "sub_plugin_test_support.hpp"

namespace weir::subplugin {
namespace sub_plugin_trainers_test {

std::string refusal(const char* name) {
  const auto opened = open(Kind::Trainer, name);
  if (opened) return *opened ? "" : "there is none";
  EXPECT_EQ(opened.error().code, Code::MODULE_REFUSED);
  return opened.error().message();
}

TEST(SubPluginTrainer, IsOpenedByItsName) {
  EXPECT_EQ(table().find(Kind::Trainer, "taking"), nullptr) << "not before it is requested";
  const auto opened = open(Kind::Trainer, "taking");
  ASSERT_TRUE(opened && *opened) << refusal("taking");
  const auto& trainer = *static_cast<const GstTensorTrainerFramework*>(*opened);
  void* priv = nullptr;
  GstTensorTrainerProperties properties{};
  EXPECT_EQ(trainer.create(&trainer, &properties, &priv), 0);
  EXPECT_EQ(priv, &trainer);
  EXPECT_EQ(trainer.getStatus(&trainer, &properties, priv), 0);
  EXPECT_EQ(properties.epoch_count, 1u);
  EXPECT_EQ(*open(Kind::Trainer, "taking"), *opened);
  EXPECT_EQ(refusal("nowhere"), "there is none");
}

TEST(SubPluginTrainer, IsListed) {
  const auto names = available(Kind::Trainer);
  EXPECT_TRUE(std::find(names.begin(), names.end(), "taking") != names.end());
  EXPECT_EQ(find_file(Kind::Trainer, "taking"),
            test::built_sub_plugin("libnnstreamer_trainer_taking.so").string());
}

TEST(SubPluginTrainer, IsRejectedWithAMessage) {
  for (int i = 0; i < 2; ++i) {
    EXPECT_SAYS(refusal("unnamed"),
                "a trainer was rejected: the trainer's getFrameworkInfo returns no name (NULL)");
    EXPECT_SAYS(refusal("later"),
                "the trainer has an unsupported interface version (0xDEAFDEAD00020000)");
    EXPECT_SAYS(refusal("partly"),
                "the trainer partly lacks required members (without stop, push_data)");
    EXPECT_SAYS(refusal("auto"), "this name is reserved (auto)");
  }
}

TEST(SubPluginTrainer, IsUnregisteredAndReportsUnhandledEvents) {
  ASSERT_EQ(refusal("taking"), "");
  auto* trainer = static_cast<GstTensorTrainerFramework*>(
      const_cast<void*>(table().find(Kind::Trainer, "taking")));
  EXPECT_TRUE(WEIR_LIBRARY(nnstreamer_trainer_exit)(trainer));
  EXPECT_FALSE(WEIR_LIBRARY(nnstreamer_trainer_exit)(trainer));
  EXPECT_FALSE(WEIR_LIBRARY(nnstreamer_trainer_exit)(nullptr));
  EXPECT_EQ(table().find(Kind::Trainer, "taking"), nullptr);
  EXPECT_FALSE(WEIR_LIBRARY(nnstreamer_trainer_probe)(nullptr));
  EXPECT_TRUE(WEIR_LIBRARY(nnstreamer_trainer_probe)(trainer));
  EXPECT_FALSE(WEIR_LIBRARY(nnstreamer_trainer_probe)(trainer)) << "its name is taken";
}

}  // namespace sub_plugin_trainers_test
}  // namespace weir::subplugin

int main(int argc, char** argv) {
  weir::process::take_objects_from(weir_process_object);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
