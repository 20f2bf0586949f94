#pragma once

// Mutators for files of known layout: one to three fields at once get values that lie at limits, or of another field. Counts
// and checksums are the caller's to repair. Random bytes hardly ever set two fields to a bad pair, nor get past a checksum.

#include <cstddef>
#include <cstdint>
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
/// Records by kind: those of a header, those of a table's entries. Any kind may be empty, and any record.
using Records = std::vector<std::vector<Record>>;
using File = std::vector<std::uint8_t>;

/// Appends `count` fields of a type that follow each other.
void add_fields(Record& record, std::size_t at, FieldType type, std::size_t count = 1);

struct FileFormat {
  std::size_t header_bytes = 0;  ///< a shorter file has no fields
  Records (*records_of)(const File& file) = nullptr;
  void (*repair)(File& file) = nullptr;  ///< makes counts right, most of the time; null: there is nothing to repair
};

/// What LLVMFuzzerCustomMutator does: sets one to three fields, mostly of one record, now and then the same field of all records of a kind.
/// What does not lie in the file stays. One in four times the bytes are mutated as those of any file.
std::size_t mutate(const FileFormat& format, std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed);

}  // namespace coppice::test
