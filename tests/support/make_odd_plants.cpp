// Writes odd_plants.h's plants into a folder, to be looked at: make_odd_plants FOLDER

#include <cstdio>
#include <filesystem>

#include "gltf_builder.h"
#include "odd_plants.h"

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::fprintf(stderr, "usage: make_odd_plants FOLDER\n");
    return 2;
  }
  for (const coppice::bake::test::OddPlant& plant : coppice::bake::test::odd_plants())
    coppice::test::write_file(std::filesystem::path(arguments[1]) / (plant.name + ".glb"), coppice::bake::test::encode(plant));
}
