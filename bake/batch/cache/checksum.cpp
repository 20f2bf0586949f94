#include "checksum.h"

#include <cstdio>
#include <new>

#include <xxhash.h>

#include "text_bytes.h"

namespace coppice::bake {

struct Checksum::State {
  XXH3_state_t* hash = XXH3_createState();
};

Checksum::Checksum() : state_(std::make_unique<State>()) {
  if (state_->hash == nullptr || XXH3_128bits_reset(state_->hash) != XXH_OK) throw std::bad_alloc();
}

Checksum::~Checksum() {
  XXH3_freeState(state_->hash);
}

void Checksum::add(std::span<const std::uint8_t> part) {
  const std::uint64_t length = part.size();
  static_cast<void>(XXH3_128bits_update(state_->hash, &length, sizeof length));
  static_cast<void>(XXH3_128bits_update(state_->hash, part.data(), part.size()));
}

void Checksum::add(std::string_view part) {
  add(bytes_of(part));
}

std::string Checksum::text() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(state_->hash);
  char text[33];
  static_cast<void>(std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                                  static_cast<unsigned long long>(hash.low64)));
  return text;
}

}  // namespace coppice::bake
