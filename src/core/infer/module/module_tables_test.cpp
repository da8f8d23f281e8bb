// Tests tables whose length differs from this host's.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/module_tables.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

#include "core/infer/module/module_check.hpp"
#include "says.hpp"

namespace weir::infer {
namespace module_tables_test {

// A table of a module that knew only its first `bytes`: reading further crashes, or finds 0xff up
// to the next address at which a table may lie.
template <class Table>
class ShortTable {
 public:
  ShortTable(Table table, size_t bytes) : page_(static_cast<size_t>(sysconf(_SC_PAGESIZE))) {
    memory_ = mmap(nullptr, 2 * page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory_ == MAP_FAILED) throw std::bad_alloc();
    mprotect(static_cast<char*>(memory_) + page_, page_, PROT_NONE);
    table.struct_size = static_cast<uint32_t>(bytes);
    const size_t whole = (bytes + alignof(Table) - 1) / alignof(Table) * alignof(Table);
    at_ = static_cast<char*>(memory_) + page_ - whole;
    std::memset(at_, 0xff, whole);
    std::memcpy(at_, &table, bytes);
  }
  ShortTable(const ShortTable&) = delete;
  ShortTable& operator=(const ShortTable&) = delete;
  ~ShortTable() { munmap(memory_, 2 * page_); }
  const Table* get() const { return reinterpret_cast<const Table*>(at_); }

 private:
  size_t page_;
  void* memory_;
  char* at_;
};

template <class Table>
Table headed(const char* name) {
  Table table{};
  table.struct_size = sizeof table;
  table.abi_major = WEIR_ABI_MAJOR;
  table.name = name;
  return table;
}
weir_engine engine(const char* name) {
  auto table = headed<weir_engine>(name);
  table.open = [](auto...) { return 0; };
  table.close = [](auto...) {};
  table.info = [](auto...) { return 0; };
  table.session_new = [](auto...) { return 0; };
  table.session_free = [](auto...) {};
  table.invoke = [](auto...) { return 0; };
  return table;
}
weir_module module_of(const weir_engine* const* engines) {
  weir_module module{};
  module.struct_size = sizeof module;
  module.abi_major = WEIR_ABI_MAJOR;
  module.engines = engines;
  return module;
}

TEST(ModuleNotLoaded, NamesALibraryThatTheModuleNeeds) {
  const auto error = module_not_loaded(
      "/x/my filter.so", "libdep.so.1: cannot open shared object file: No such file or directory");
  EXPECT_EQ(error.what, "a library that /x/my filter.so needs is missing");
  EXPECT_EQ(error.needed, "libdep.so.1, in a folder that the loader searches");
  EXPECT_EQ(error.fix,
            "ldd '/x/my filter.so' shows what is missing: install it, or export "
            "LD_LIBRARY_PATH=/its/folder");
  EXPECT_EQ(module_not_loaded("/x/f.so", "/x/f.so: undefined symbol: dep").what,
            "the module /x/f.so cannot be used");
  EXPECT_EQ(module_not_loaded("/x/f.so", "/x/f.so: cannot open shared object file: No").what,
            "the module /x/f.so cannot be used");
  EXPECT_EQ(module_not_loaded("/x/f.so", nullptr).offered, "dlopen failed");
}

TEST(ModuleTables, OfAnOlderModuleEndInNulls) {
  const ShortTable<weir_engine> older(engine("older"), offsetof(weir_engine, submit));
  const weir_engine* const engines[] = {older.get(), nullptr};
  const ShortTable<weir_module> module(module_of(engines), offsetof(weir_module, trainers));
  const auto tables = ModuleTables::copy(module.get(), "older.so");
  ASSERT_TRUE(tables) << tables.error().message();
  const weir_engine* found = (*tables)->module().engines[0];
  ASSERT_NE(found, nullptr);
  EXPECT_STREQ(found->name, "older");
  EXPECT_EQ(found->invoke, older.get()->invoke);
  EXPECT_EQ(found->submit, nullptr);
  EXPECT_EQ(found->control, nullptr);
  EXPECT_EQ(found->extension, nullptr);
  EXPECT_EQ((*tables)->module().engines[1], nullptr);
  EXPECT_EQ((*tables)->module().extension, nullptr);
}

TEST(ModuleTables, DoNotHaveAMemberWithinWhichTheyEnd) {
  auto whole = engine("cut");
  whole.submit = [](auto...) { return 0; };
  whole.cancel = [](auto...) {};
  auto whole_module = module_of(nullptr);
  whole_module.extension = [](const char*) -> const void* { return nullptr; };
  for (size_t cut = 1; cut < sizeof(void*); ++cut) {
    const ShortTable<weir_engine> engine(whole, offsetof(weir_engine, cancel) + cut);
    const weir_engine* const engines[] = {engine.get(), nullptr};
    whole_module.engines = engines;
    const ShortTable<weir_module> module(whole_module, offsetof(weir_module, extension) + cut);
    const auto tables = ModuleTables::copy(module.get(), "cut.so");
    ASSERT_TRUE(tables) << tables.error().message();
    EXPECT_EQ((*tables)->module().engines[0]->submit, whole.submit);
    EXPECT_EQ((*tables)->module().engines[0]->cancel, nullptr) << cut;
    EXPECT_EQ((*tables)->module().extension, nullptr) << cut;
  }
}

TEST(ModuleTables, OfANewerModuleAreReadAsFarAsTheyAreKnown) {
  struct Newer {
    weir_engine known;
    void* more[8];
  } newer{engine("newer"), {}};
  newer.known.struct_size = sizeof newer;
  newer.known.abi_minor = WEIR_ABI_MINOR + 1;
  newer.more[0] = &newer;
  const weir_engine* const engines[] = {&newer.known, nullptr};
  const weir_module module = module_of(engines);
  const auto tables = ModuleTables::copy(&module, "newer.so");
  ASSERT_TRUE(tables) << tables.error().message();
  EXPECT_EQ((*tables)->module().engines[0]->struct_size, sizeof(weir_engine));
  EXPECT_EQ((*tables)->module().engines[0]->invoke, newer.known.invoke);
}

TEST(ModuleTables, ListsAreNeverNull) {
  const weir_module empty = module_of(nullptr);
  const auto tables = ModuleTables::copy(&empty, "empty.so");
  ASSERT_TRUE(tables);
  EXPECT_EQ((*tables)->module().engines[0], nullptr);
  EXPECT_EQ((*tables)->module().decoders[0], nullptr);
  EXPECT_EQ((*tables)->module().converters[0], nullptr);
}

TEST(ModuleTables, ThatAreTooShortAreRejectedWithAMessage) {
  const ShortTable<weir_engine> head(engine("head"), offsetof(weir_engine, open));
  const weir_engine* const engines[] = {head.get(), nullptr};
  const weir_module module = module_of(engines);
  const auto tables = ModuleTables::copy(&module, "head.so");
  ASSERT_FALSE(tables);
  EXPECT_EQ(tables.error().code, Code::MODULE_REFUSED);
  const std::string text = tables.error().message();
  EXPECT_SAYS(text, "head.so");
  EXPECT_SAYS(
      text, "an engine with a table of " + std::to_string(offsetof(weir_engine, open)) + " bytes");
}

TEST(ModuleTables, OfAnotherMajorVersionAreRejected) {
  auto other = engine("other");
  other.abi_major = WEIR_ABI_MAJOR + 1;
  const weir_engine* const engines[] = {&other, nullptr};
  const weir_module module = module_of(engines);
  const auto tables = ModuleTables::copy(&module, "other.so");
  ASSERT_FALSE(tables);
  EXPECT_SAYS(tables.error().message(), "ABI version 2");
}

}  // namespace module_tables_test
}  // namespace weir::infer
