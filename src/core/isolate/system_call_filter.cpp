// Compiles rules to BPF: one comparison per call, then its rules in order.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/isolate/system_call_filter.hpp"

#include <linux/audit.h>
#include <linux/seccomp.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace weir::isolate {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the low half of an argument is first");

#if defined(__aarch64__)
constexpr uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#endif

using Program = std::vector<sock_filter>;

void load(Program* out, size_t offset) {
  out->push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<uint32_t>(offset)));
}
void skip_unless(Program* out, uint16_t comparison, uint32_t value, size_t steps) {
  out->push_back(BPF_JUMP(static_cast<uint16_t>(BPF_JMP | comparison | BPF_K), value, 0,
                          static_cast<uint8_t>(steps)));
}
void decide(Program* out, int error) {
  out->push_back(BPF_STMT(BPF_RET | BPF_K, error == 0
                                               ? SECCOMP_RET_ALLOW
                                               : SECCOMP_RET_ERRNO | static_cast<uint32_t>(error)));
}

struct HalfCheck {
  size_t offset;
  uint32_t mask, value;
};

// BPF computes with 32 bits, so an argument is checked in two halves.
std::vector<HalfCheck> halves(const SystemCallRule& rule) {
  std::vector<HalfCheck> out;
  for (const auto& check : rule.checks)
    for (const size_t half : {0u, 1u}) {
      const auto mask = static_cast<uint32_t>(check.mask >> (32 * half));
      const auto value = static_cast<uint32_t>(check.value >> (32 * half));
      const size_t offset = offsetof(seccomp_data, args) + size_t{8} * check.argument + 4 * half;
      if (mask != 0) out.push_back({offset, mask, value});
    }
  return out;
}

// Returns a verdict if all checks hold; otherwise continues after itself.
Program make_program(const SystemCallRule& rule) {
  constexpr size_t kStepsOfACheck = 3;
  const auto checks = halves(rule);
  Program out;
  for (size_t left = checks.size(); const auto& check : checks) {
    load(&out, check.offset);
    out.push_back(BPF_STMT(BPF_ALU | BPF_AND | BPF_K, check.mask));
    skip_unless(&out, BPF_JEQ, check.value, --left * kStepsOfACheck + 1);
  }
  decide(&out, rule.error);
  return out;
}

// The rules for one call. EPERM if none of them decides.
Program make_program(std::span<const SystemCallRule> rules) {
  Program out;
  for (const auto& rule : rules) {
    const Program part = make_program(rule);
    out.insert(out.end(), part.begin(), part.end());
  }
  if (!halves(rules.back()).empty()) decide(&out, EPERM);
  return out;
}

}  // namespace

std::vector<sock_filter> compile(std::span<const SystemCallRule> rules) {
  Program out;
  load(&out, offsetof(seccomp_data, arch));
  out.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0));
  decide(&out, ENOSYS);  // programs for another ABI number calls differently
  load(&out, offsetof(seccomp_data, nr));
  skip_unless(&out, BPF_JGT, kNewestCall, 1);
  decide(&out, ENOSYS);
  while (!rules.empty()) {
    const auto is_same = [&](const SystemCallRule& rule) { return rule.call == rules[0].call; };
    const auto end = std::find_if_not(rules.begin(), rules.end(), is_same);
    const auto part = make_program(rules.first(static_cast<size_t>(end - rules.begin())));
    const auto call = static_cast<uint32_t>(rules[0].call);
    if (part.size() <= UINT8_MAX) {
      skip_unless(&out, BPF_JEQ, call, part.size());
    } else {  // too far for a conditional jump
      out.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 1, 0));
      out.push_back(BPF_STMT(BPF_JMP | BPF_JA, static_cast<uint32_t>(part.size())));
    }
    out.insert(out.end(), part.begin(), part.end());
    rules = rules.subspan(static_cast<size_t>(end - rules.begin()));
  }
  decide(&out, EPERM);
  return out;
}

std::string filter_system_calls() {
  const auto rules = worker_rules(getpid());
  if (rules.empty()) return "there is no table of system calls for this architecture";
  auto steps = compile(rules);
  const sock_fprog filter{static_cast<unsigned short>(steps.size()), steps.data()};
  // All threads: a library preloaded by the environment may have started one.
  const long other =
      syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &filter);
  if (other > 0) return "thread " + std::to_string(other) + " has its own filter";
  return other == 0 ? "" : std::strerror(errno);
}

}  // namespace weir::isolate
