#include "material_words.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace coppice::bake {
namespace {

using enum WordKind;

constexpr std::array kWords{
    MaterialWord{"leaf", leaf},
    MaterialWord{"leaves", leaf},
    MaterialWord{"foliage", leaf},
    MaterialWord{"foliole", leaf},
    MaterialWord{"needle", leaf},
    MaterialWord{"frond", leaf},
    MaterialWord{"canopy", leaf},
    MaterialWord{"grass", leaf},
    MaterialWord{"fern", leaf, true},
    MaterialWord{"ferns", leaf, true},
    MaterialWord{"ivy", leaf, true},
    MaterialWord{"lvs", leaf, true},
    MaterialWord{"blatt", leaf},
    MaterialWord{"blätt", leaf},
    MaterialWord{"laub", leaf},
    MaterialWord{"nadel", leaf},
    MaterialWord{"wedel", leaf},
    MaterialWord{"gras", leaf, true},
    MaterialWord{"feuill", leaf},
    MaterialWord{"aiguille", leaf},
    MaterialWord{"hoja", leaf},
    MaterialWord{"follaje", leaf},
    MaterialWord{"folha", leaf},
    MaterialWord{"foglia", leaf},
    MaterialWord{"foglie", leaf},
    MaterialWord{"blad", leaf},
    MaterialWord{"lehti", leaf},
    MaterialWord{"lehdet", leaf},
    MaterialWord{"yaprak", leaf},
    MaterialWord{"liść", leaf},
    MaterialWord{"liście", leaf},
    MaterialWord{"liscie", leaf},
    MaterialWord{"лист", leaf},
    MaterialWord{"хвоя", leaf},
    MaterialWord{"φύλλ", leaf},
    MaterialWord{"φυλλ", leaf},
    MaterialWord{"herbe", leaf},
    MaterialWord{"hierba", leaf},
    MaterialWord{"césped", leaf},
    MaterialWord{"erba", leaf, true},
    MaterialWord{"relva", leaf, true},
    MaterialWord{"gräs", leaf},
    MaterialWord{"trawa", leaf},
    MaterialWord{"трава", leaf},
    MaterialWord{"травы", leaf},
    MaterialWord{"γρασίδι", leaf},
    MaterialWord{"草", leaf},
    MaterialWord{"芝", leaf},
    MaterialWord{"잔디", leaf},
    MaterialWord{"farn", leaf, true},
    MaterialWord{"fougère", leaf},
    MaterialWord{"helecho", leaf},
    MaterialWord{"samambaia", leaf},
    MaterialWord{"felce", leaf},
    MaterialWord{"felci", leaf, true},
    MaterialWord{"varen", leaf, true},
    MaterialWord{"ormbunk", leaf},
    MaterialWord{"paproć", leaf},
    MaterialWord{"папоротник", leaf},
    MaterialWord{"φτέρη", leaf},
    MaterialWord{"蕨", leaf},
    MaterialWord{"シダ", leaf},
    MaterialWord{"고사리", leaf},
    MaterialWord{"aguja", leaf},
    MaterialWord{"agulha", leaf},
    MaterialWord{"aghi", leaf, true},
    MaterialWord{"naald", leaf},
    MaterialWord{"barr", leaf, true},
    MaterialWord{"neula", leaf},
    MaterialWord{"iğne", leaf},
    MaterialWord{"игла", leaf, true},
    MaterialWord{"иглы", leaf, true},
    MaterialWord{"βελόν", leaf},
    MaterialWord{"叶", leaf},
    MaterialWord{"葉", leaf},
    MaterialWord{"잎", leaf},

    MaterialWord{"petal", flower},
    MaterialWord{"flower", flower},
    MaterialWord{"blossom", flower},
    MaterialWord{"bloom", flower},
    MaterialWord{"blüte", flower},
    MaterialWord{"fleur", flower},
    MaterialWord{"pétale", flower},
    MaterialWord{"flor", flower, true},
    MaterialWord{"fiore", flower},
    MaterialWord{"bloem", flower},
    MaterialWord{"bloesem", flower},
    MaterialWord{"pétalo", flower},
    MaterialWord{"petalo", flower},
    MaterialWord{"blomma", flower},
    MaterialWord{"blommor", flower},
    MaterialWord{"kukka", flower, true},
    MaterialWord{"kukat", flower, true},
    MaterialWord{"çiçek", flower},
    MaterialWord{"kwiat", flower},
    MaterialWord{"цветок", flower},
    MaterialWord{"цветы", flower},
    MaterialWord{"лепест", flower},
    MaterialWord{"λουλούδ", flower},
    MaterialWord{"꽃", flower},
    MaterialWord{"花", flower},

    MaterialWord{"plant", plant, true},
    MaterialWord{"plants", plant, true},
    MaterialWord{"bush", plant, true},
    MaterialWord{"bushes", plant, true},
    MaterialWord{"shrub", plant, true},
    MaterialWord{"shrubs", plant, true},
    MaterialWord{"hedge", plant, true},
    MaterialWord{"vegetation", plant, true},
    MaterialWord{"greenery", plant, true},
    MaterialWord{"weed", plant, true},
    MaterialWord{"weeds", plant, true},
    MaterialWord{"reed", plant, true},
    MaterialWord{"reeds", plant, true},
    MaterialWord{"sedge", plant, true},
    MaterialWord{"moss", plant, true},
    MaterialWord{"clover", plant, true},
    MaterialWord{"seaweed", plant, true},
    MaterialWord{"kelp", plant, true},
    MaterialWord{"pflanze", plant, true},
    MaterialWord{"pflanzen", plant, true},
    MaterialWord{"busch", plant, true},
    MaterialWord{"büsche", plant, true},
    MaterialWord{"strauch", plant, true},
    MaterialWord{"hecke", plant, true},
    MaterialWord{"schilf", plant, true},
    MaterialWord{"plante", plant, true},
    MaterialWord{"plantes", plant, true},
    MaterialWord{"buisson", plant, true},
    MaterialWord{"haie", plant, true},
    MaterialWord{"roseau", plant, true},
    MaterialWord{"planta", plant, true},
    MaterialWord{"plantas", plant, true},
    MaterialWord{"arbusto", plant, true},
    MaterialWord{"arbustos", plant, true},
    MaterialWord{"seto", plant, true},
    MaterialWord{"junco", plant, true},
    MaterialWord{"sebe", plant, true},
    MaterialWord{"pianta", plant, true},
    MaterialWord{"piante", plant, true},
    MaterialWord{"cespuglio", plant, true},
    MaterialWord{"siepe", plant, true},
    MaterialWord{"canna", plant, true},
    MaterialWord{"struik", plant, true},
    MaterialWord{"heg", plant, true},
    MaterialWord{"riet", plant, true},
    MaterialWord{"växt", plant, true},
    MaterialWord{"buske", plant, true},
    MaterialWord{"häck", plant, true},
    MaterialWord{"kasvi", plant, true},
    MaterialWord{"pensas", plant, true},
    MaterialWord{"bitki", plant, true},
    MaterialWord{"çalı", plant, true},
    MaterialWord{"roślina", plant, true},
    MaterialWord{"krzew", plant, true},
    MaterialWord{"żywopłot", plant, true},
    MaterialWord{"растение", plant, true},
    MaterialWord{"растения", plant, true},
    MaterialWord{"куст", plant, true},
    MaterialWord{"кусты", plant, true},
    MaterialWord{"θάμνος", plant, true},
    MaterialWord{"灌木", plant},
    MaterialWord{"植物", plant},
    MaterialWord{"풀", plant},

    MaterialWord{"branch", twig},
    MaterialWord{"twig", twig},
    MaterialWord{"stem", twig, true},
    MaterialWord{"stems", twig, true},
    MaterialWord{"stalk", twig},
    MaterialWord{"shoot", twig},
    MaterialWord{"petiole", twig},
    MaterialWord{"rachis", twig},
    MaterialWord{"zweig", twig},
    MaterialWord{"ast", twig, true},
    MaterialWord{"äste", twig, true},
    MaterialWord{"stiel", twig},
    MaterialWord{"stängel", twig},
    MaterialWord{"rameau", twig},
    MaterialWord{"tige", twig, true},
    MaterialWord{"rama", twig, true},
    MaterialWord{"ramas", twig, true},
    MaterialWord{"ramo", twig, true},
    MaterialWord{"tallo", twig},
    MaterialWord{"caule", twig, true},
    MaterialWord{"gambo", twig, true},
    MaterialWord{"tak", twig, true},
    MaterialWord{"takken", twig, true},
    MaterialWord{"gren", twig, true},
    MaterialWord{"oksa", twig, true},
    MaterialWord{"gałąź", twig},
    MaterialWord{"ветк", twig},
    MaterialWord{"ветв", twig},
    MaterialWord{"枝", twig},

    MaterialWord{"bark", other},
    MaterialWord{"trunk", other},
    MaterialWord{"wood", other},
    MaterialWord{"timber", other},
    MaterialWord{"stump", other},
    MaterialWord{"log", other, true},
    MaterialWord{"root", other, true},
    MaterialWord{"roots", other, true},
    MaterialWord{"rinde", other, true},
    MaterialWord{"borke", other},
    MaterialWord{"stamm", other},
    MaterialWord{"holz", other},
    MaterialWord{"wurzel", other},
    MaterialWord{"écorce", other},
    MaterialWord{"ecorce", other},
    MaterialWord{"tronc", other},
    MaterialWord{"bois", other, true},
    MaterialWord{"racine", other},
    MaterialWord{"corteza", other},
    MaterialWord{"madera", other},
    MaterialWord{"casca", other, true},
    MaterialWord{"madeira", other},
    MaterialWord{"corteccia", other},
    MaterialWord{"legno", other},
    MaterialWord{"radice", other},
    MaterialWord{"schors", other},
    MaterialWord{"stam", other, true},
    MaterialWord{"hout", other, true},
    MaterialWord{"kora", other, true},
    MaterialWord{"pień", other, true},
    MaterialWord{"кора", other, true},
    MaterialWord{"ствол", other},
    MaterialWord{"树皮", other},
    MaterialWord{"樹皮", other},
    MaterialWord{"树干", other},
    MaterialWord{"樹幹", other},
    MaterialWord{"幹", other},
    MaterialWord{"pot", other, true},
    MaterialWord{"planter", other},
    MaterialWord{"vase", other, true},
    MaterialWord{"soil", other},
    MaterialWord{"ground", other},
    MaterialWord{"dirt", other},
    MaterialWord{"earth", other, true},
    MaterialWord{"terrain", other},
    MaterialWord{"rock", other},
    MaterialWord{"stone", other},
    MaterialWord{"gravel", other},
    MaterialWord{"pebble", other},
    MaterialWord{"snow", other},
    MaterialWord{"fruit", other},
    MaterialWord{"berry", other, true},
    MaterialWord{"berries", other, true},
    MaterialWord{"acorn", other},
    MaterialWord{"cone", other, true},
    MaterialWord{"cones", other, true},
    MaterialWord{"nut", other, true},
    MaterialWord{"nuts", other, true},
    MaterialWord{"coconut", other},
    MaterialWord{"seed", other, true},
    MaterialWord{"seeds", other, true},
    MaterialWord{"topf", other},
    MaterialWord{"erde", other, true},
    MaterialWord{"boden", other},
    MaterialWord{"frucht", other},
    MaterialWord{"früchte", other},
    MaterialWord{"schnee", other},
    MaterialWord{"terre", other, true},
    MaterialWord{"neige", other},
    MaterialWord{"fruta", other},
    MaterialWord{"fruto", other},
    MaterialWord{"frutto", other},
    MaterialWord{"maceta", other},
    MaterialWord{"suelo", other},
    MaterialWord{"nieve", other},
    MaterialWord{"terra", other, true},
    MaterialWord{"neve", other, true},
};

constexpr std::size_t kMaxNameBytes = 256;

double worth(WordKind kind) {
  switch (kind) {
    case leaf:
      return 3.0;
    case flower:
    case plant:
      return 1.0;
    case twig:
      return -1.0;
    case other:
      break;
  }
  return -3.0;
}

bool is_capital(char c) {
  return c >= 'A' && c <= 'Z';
}
bool is_small(char c) {
  return c >= 'a' && c <= 'z';
}

/// Two bytes of UTF-8 in lower case, for the capitals of Latin-1, Greek and Russian.
void lower_pair(unsigned char& lead, unsigned char& next) {
  if (lead == 0xc3 && next >= 0x80 && next <= 0x9e) next = static_cast<unsigned char>(next + 0x20);               // À..Þ
  if (lead == 0xce && next >= 0x91 && next <= 0x9f) next = static_cast<unsigned char>(next + 0x20);               // Α..Ο
  if (lead == 0xce && next >= 0xa0 && next <= 0xa9) lead = 0xcf, next = static_cast<unsigned char>(next - 0x20);  // Π..Ω
  if (lead == 0xd0 && next >= 0x90 && next <= 0x9f) next = static_cast<unsigned char>(next + 0x20);               // А..П
  if (lead == 0xd0 && next >= 0xa0 && next <= 0xaf) lead = 0xd1, next = static_cast<unsigned char>(next - 0x20);  // Р..Я
}

/// The name in lower case, words apart by single spaces, a space at either end.
std::string spaced(std::string_view name) {
  std::string words = " ";
  char before = ' ';
  for (const char c : name.substr(0, kMaxNameBytes)) {
    const bool letter = is_capital(c) || is_small(c) || static_cast<unsigned char>(c) >= 0x80;
    const bool new_word = is_capital(c) && is_small(before);
    before = c;
    if ((!letter || new_word) && words.back() != ' ') words += ' ';
    if (letter) words += is_capital(c) ? static_cast<char>(c - 'A' + 'a') : c;
  }
  if (words.back() != ' ') words += ' ';
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    auto lead = static_cast<unsigned char>(words[i]), next = static_cast<unsigned char>(words[i + 1]);
    lower_pair(lead, next);
    words[i] = static_cast<char>(lead);
    words[i + 1] = static_cast<char>(next);
  }
  return words;
}

bool contains(const std::string& words, const MaterialWord& word) {
  if (!word.whole) return words.find(word.text) != std::string::npos;
  return words.find(" " + std::string(word.text) + " ") != std::string::npos;
}

bool has(const std::string& words, WordKind kind) {
  return std::any_of(kWords.begin(), kWords.end(), [&](const MaterialWord& word) { return word.kind == kind && contains(words, word); });
}

double evidence_of_parts(const std::string& words) {
  double sum = 0.0;
  for (const WordKind kind : {leaf, flower, twig, other})
    if (has(words, kind)) sum += worth(kind);
  return sum;
}

}  // namespace

std::span<const MaterialWord> material_words() {
  return kWords;
}

double name_evidence(std::string_view name) {
  const std::string words = spaced(name);
  const double parts = evidence_of_parts(words);
  // Part of what else the name says: "plant_pot".
  return parts == 0.0 && has(words, plant) ? worth(plant) : parts;
}

double part_evidence(std::string_view name) {
  return evidence_of_parts(spaced(name));
}

}  // namespace coppice::bake
