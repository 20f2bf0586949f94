#pragma once

// The files that a glTF names: its buffers and images. Whoever made the glTF chose the names, so they reach files outside its folder only
// if that is allowed. Also reads its JSON unchecked, for those who only look which files these are; a bake checks it (gltf_document.h).

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "asset_path.h"
#include "result.h"

namespace coppice::bake {

/// Maximum size of an image file. An image of as many pixels as are decoded takes less, in any form.
inline constexpr std::uint64_t kMaxImageFileBytes = std::uint64_t{1} << 30;

/// Hears of every file that an import reads. uri  as the document names it; empty: the document itself. bytes  none where it is missing
using ReadObserver = std::function<void(std::string_view uri, std::span<const std::uint8_t> bytes)>;

/// Turns "a%20b" into "a b".
std::string percent_decoded(std::string_view uri);

/// A buffer or image of a document, if it is a file.
struct GltfReference {
  bool is_buffer = false;
  std::size_t index = 0;
  std::string uri;
  std::uint64_t used_bytes = 0;  ///< maximum of the file that is read: the buffer's byteLength, kMaxImageFileBytes

  /// Names it in messages: "buffers[0].uri".
  [[nodiscard]] std::string place() const;
};

/// Lists buffers, then images, in their order. Leaves out members of the wrong type.
std::vector<GltfReference> find_references(const nlohmann::json& document);

/// The path that a URI means, whatever is there.
std::filesystem::path named_file(const std::filesystem::path& folder, std::string_view uri);

/// Finds the plain file that `uri` means in a glTF of `folder`; follows symbolic links.
/// place   names the URI in messages: "buffers[0].uri"
/// errors  `detail` is place and URI. invalid_argument: it is outside the folder, and that is refused; bad_file: no name of a file;
///         io: no such file, not a plain one, or the system's reason
Result<std::filesystem::path> resolve_reference(const std::filesystem::path& folder, std::string_view uri, const std::string& place,
                                                OutsideFiles outside);

/// Finds the JSON in the bytes of a .gltf, without a byte order mark, or of a .glb; empty if there is none.
std::string_view gltf_text(std::span<const std::uint8_t> gltf);

/// Reads as many of a file's bytes as gltf_text needs: of a .glb those up to its JSON's end, at most `max_bytes`.
/// errors  as read_file
Result<std::vector<std::uint8_t>> read_gltf_text(const std::filesystem::path& file, std::uint64_t max_bytes);

}  // namespace coppice::bake
