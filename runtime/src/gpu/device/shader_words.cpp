// A SPIR-V module is a header of five words, then instructions: the opcode is in the low half of the first word, the word count in the high
// half. All outputs with a location have one type, so only one more pointer type must be declared.

#include "shader_words.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace coppice::gpu {
namespace {

constexpr std::size_t kHeaderWords = 5, kBound = 3;
constexpr std::uint32_t kOpTypePointer = 32, kOpVariable = 59, kOpDecorate = 71;
constexpr std::uint32_t kOpSelectionMerge = 247, kOpBranch = 249, kOpBranchConditional = 250;
constexpr std::uint32_t kOutput = 3, kPrivate = 6;    // storage classes
constexpr std::uint32_t kSpecId = 1, kLocation = 30;  // decorations

std::uint32_t opcode(std::uint32_t word) {
  return word & 0xffffu;
}
std::size_t word_count(std::uint32_t word) {
  return std::max<std::size_t>(word >> 16, 1);
}

/// Calls visit(words) for each instruction.
template <class Visit>
void for_each_instruction(std::span<const std::uint32_t> words, const Visit& visit) {
  for (std::size_t at = kHeaderWords; at < words.size();) {
    const std::size_t count = std::min(word_count(words[at]), words.size() - at);
    visit(words.subspan(at, count));
    at += count;
  }
}

/// The outputs that a module declares.
struct Outputs {
  std::vector<std::uint32_t> beyond;  ///< ids of outputs at locations from color_count on
  std::uint32_t pointer = 0;          ///< their type
  std::uint32_t pointee = 0;

  [[nodiscard]] bool has(std::uint32_t id) const { return std::ranges::find(beyond, id) != beyond.end(); }
};

bool is_location(std::span<const std::uint32_t> op) {
  return opcode(op[0]) == kOpDecorate && op.size() == 4 && op[2] == kLocation;
}

bool is_output(std::span<const std::uint32_t> op) {
  return opcode(op[0]) == kOpVariable && op.size() >= 4 && op[3] == kOutput;
}

Outputs outputs_of(std::span<const std::uint32_t> words, std::uint32_t color_count) {
  Outputs outputs;
  std::vector<std::uint32_t> beyond;                              // inputs too
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pointees;  // pointers to outputs
  for_each_instruction(words, [&](std::span<const std::uint32_t> op) {
    if (is_location(op) && op[3] >= color_count) beyond.push_back(op[1]);
    if (opcode(op[0]) == kOpTypePointer && op[2] == kOutput) pointees.emplace_back(op[1], op[3]);
    if (!is_output(op) || std::ranges::find(beyond, op[2]) == beyond.end()) return;
    outputs.beyond.push_back(op[2]);
    outputs.pointer = op[1];
  });
  for (const auto& [pointer, pointee] : pointees)
    if (pointer == outputs.pointer) outputs.pointee = pointee;
  return outputs;
}

}  // namespace

std::vector<std::uint32_t> with_outputs(std::span<const std::uint32_t> words, std::uint32_t color_count) {
  const Outputs outputs = outputs_of(words, color_count);
  if (outputs.beyond.empty()) return {words.begin(), words.end()};
  std::vector<std::uint32_t> kept(words.begin(), words.begin() + kHeaderWords);
  kept.reserve(words.size() + 4);
  const std::uint32_t private_pointer = kept[kBound]++;
  bool declared = false;
  for_each_instruction(words, [&](std::span<const std::uint32_t> op) {
    if (is_location(op) && outputs.has(op[1])) return;
    const bool dropped = is_output(op) && outputs.has(op[2]);
    if (dropped && !std::exchange(declared, true))
      kept.insert(kept.end(), {4u << 16 | kOpTypePointer, private_pointer, kPrivate, outputs.pointee});
    const std::size_t at = kept.size();
    kept.insert(kept.end(), op.begin(), op.end());
    if (!dropped) return;
    kept[at + 1] = private_pointer;
    kept[at + 3] = kPrivate;
  });
  return kept;
}

std::vector<std::uint32_t> without_branches(std::span<const std::uint32_t> words, std::uint32_t constant_id) {
  std::uint32_t constant = 0;
  for_each_instruction(words, [&](std::span<const std::uint32_t> op) {
    if (opcode(op[0]) == kOpDecorate && op.size() == 4 && op[2] == kSpecId && op[3] == constant_id) constant = op[1];
  });
  std::vector<std::uint32_t> kept(words.begin(), words.begin() + kHeaderWords);
  kept.reserve(words.size());
  std::size_t before = 0;  // place of the last instruction in `kept`
  for_each_instruction(words, [&](std::span<const std::uint32_t> op) {
    if (opcode(op[0]) == kOpBranchConditional && op[1] == constant && opcode(kept[before]) == kOpSelectionMerge) {
      kept.resize(before);
      kept.insert(kept.end(), {2u << 16 | kOpBranch, op[3]});
      return;
    }
    before = kept.size();
    kept.insert(kept.end(), op.begin(), op.end());
  });
  return kept;
}

}  // namespace coppice::gpu
