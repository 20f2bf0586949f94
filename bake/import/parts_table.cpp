#include "parts_table.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "plant_size.h"
#include "printable.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMaxClasses = 6;

/// How many of a material's pieces became one part.
struct PartCount {
  std::uint64_t classes = 0, pieces = 0, triangles = 0;
};

PartCount count_part(std::span<const PieceClass> classes, PlantPart part) {
  PartCount count;
  for (const PieceClass& each : classes)
    if (each.part == part) ++count.classes, count.pieces += each.piece_count, count.triangles += each.total_triangles;
  return count;
}

/// "leaves" alone if all pieces became leaves; otherwise how many became what.
std::string becomes(std::span<const PieceClass> classes) {
  const std::array parts{std::pair{PlantPart::leaf, "leaves"}, std::pair{PlantPart::wood, "wood"},
                         std::pair{PlantPart::dropped, "dropped"}};
  std::string text;
  for (const auto& [part, name] : parts) {
    const PartCount count = count_part(classes, part);
    if (count.classes == classes.size()) return name;
    if (count.classes > 0) text += (text.empty() ? "" : ", ") + std::to_string(count.pieces) + " " + name;
  }
  return text;
}

const char* part_name(const PieceClass& each) {
  if (each.is_shell) return "wood (welded shell)";
  return each.part == PlantPart::leaf ? "leaf" : each.part == PlantPart::wood ? "wood" : "dropped";
}

std::string class_line(const PieceClass& each) {
  const std::string shape = each.triangle_count == 0
                                ? "without area"
                                : "x " + std::to_string(each.triangle_count) + " triangles, " + std::to_string(each.point_count) +
                                      " points, " + formatted("%.3g m", each.length_m);
  return formatted("  %9u %-40s %-8s %s\n", each.piece_count, shape.c_str(), part_name(each), printable(each.reason).c_str());
}

/// The printable beginning of a name that fits into `bytes`; cuts no character in two.
std::string printable_front(const std::string& name, std::size_t bytes) {
  std::string front = printable(name);
  if (front.size() <= bytes) return front;
  while (bytes > 0 && (static_cast<unsigned char>(front[bytes]) & 0xc0u) == 0x80u) --bytes;
  return front.substr(0, bytes);
}

/// Lines of one material: its own and those of its largest classes, of leaves and of the rest, each with its number.
std::string material_lines(const std::string& name, std::span<const PieceClass> classes) {
  std::uint64_t triangles = 0, pieces = 0;
  for (const PieceClass& each : classes) triangles += each.total_triangles, pieces += each.piece_count;
  const std::string shown = name.empty() ? "(unnamed)" : printable_front(name, 32);
  std::string text = formatted("%-32s %10llu %9llu %8zu  %s\n", shown.c_str(), static_cast<unsigned long long>(triangles),
                               static_cast<unsigned long long>(pieces), classes.size(), becomes(classes).c_str());
  for (const PieceClass& each : classes.first(std::min(classes.size(), kMaxClasses))) text += class_line(each);
  if (classes.size() > kMaxClasses) {
    const std::span rest = classes.subspan(kMaxClasses);
    text += formatted("            and %zu smaller classes: %s\n", rest.size(), becomes(rest).c_str());
  }
  return text;
}

}  // namespace

std::string parts_table(const Plant& plant) {
  std::string text = formatted("%-32s %10s %9s %8s  %s\n", "material", "triangles", "pieces", "classes", "becomes");
  const std::span<const PieceClass> all(plant.classes);
  for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
    while (last < all.size() && all[last].material == all[first].material) ++last;
    text += material_lines(plant.materials[all[first].material].name, all.subspan(first, last - first));
  }
  text += formatted("%zu leaves of %zu triangles; wood of %zu triangles\n", plant.leaves.size(), plant.foliage.triangle_materials.size(),
                    plant.wood.triangle_materials.size());
  return text + size_text(plant_size_m(plant)) + "\n";
}

}  // namespace coppice::bake
