#pragma once

// Mutators for files of known layout: one to three fields at once get values that lie at limits, or of another field. Counts
// and checksums are the caller's to repair. Random bytes hardly ever set two fields to a bad pair, nor get past a checksum.

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace coppice::test {

enum class FieldType : std::uint8_t { u8, u16, u32, u64, f32 };

/// A field of a file.
struct Field {
  std::size_t at = 0;
  FieldType type = FieldType::u32;
};

/// Fields that are read together, the same ones in all records of a kind.
using Record = std::vector<Field>;
/// Records by kind: those of a header, those of a table's entries.
using Records = std::vector<std::vector<Record>>;

/// Appends `count` fields of a type that follow each other.
void add_fields(Record& record, std::size_t at, FieldType type, std::size_t count = 1);

/// Sets one to three fields, mostly of one record, now and then the same field of all records of a kind. Any kind may be empty, and any
/// record; what does not lie in the file stays.
void change_fields(std::vector<std::uint8_t>& file, const Records& records, std::minstd_rand& random);

/// What LLVMFuzzerCustomMutator returns: `file` in place of what is there, cut off at max_size.
std::size_t put_mutant(const std::vector<std::uint8_t>& file, std::uint8_t* data, std::size_t max_size);

}  // namespace coppice::test
