#include "plate_text.h"

#include <math.h>
#include <string.h>

namespace slipscale {

namespace {

bool digit(char c) { return c >= '0' && c <= '9'; }

struct Meaning {
  int code;
  const char* text;
};
constexpr Meaning kMeanings[] = {
    {kOk, "No error"},
    {kDataType, "Data type error"},
    {kMissing, "Missing parameter"},
    {kUndefined, "Undefined header"},
    {kConflict, "Settings conflict"},
    {kRange, "Data out of range"},
    {kTooHot, "Over temperature"},
};

// Plain decimals only: no exponent, no nan, no inf.
bool parse_number(const char* text, float* value) {
  const bool negative = *text == '-';
  if (*text == '-' || *text == '+') ++text;
  double result = 0, place = 1;
  int whole = 0, fraction = 0;
  for (; digit(*text); ++text, ++whole) result = result * 10 + (*text - '0');
  if (*text == '.') {
    for (++text; digit(*text); ++text, ++fraction) result += (*text - '0') * (place /= 10);
    if (fraction == 0) return false;
  }
  *value = static_cast<float>(negative ? -result : result);
  return *text == '\0' && whole > 0 && whole <= 7 && fraction <= 6;
}

}  // namespace

const char* meaning(int code) {
  for (const Meaning& each : kMeanings) {
    if (each.code == code) return each.text;
  }
  return "Unknown error";
}

uint16_t crc16(const char* data, size_t length) {  // CRC-16/CCITT-FALSE, byte by byte
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < length; ++i) {
    uint16_t x = static_cast<uint16_t>((crc >> 8) ^ static_cast<uint8_t>(data[i]));
    x = static_cast<uint16_t>(x ^ (x >> 4));
    crc = static_cast<uint16_t>((crc << 8) ^ (x << 12) ^ (x << 5) ^ x);
  }
  return crc;
}

bool sequence_number(const char* text, const char* end) {
  if (*text == '0' || text == end || end - text > 5) return false;
  uint32_t number = 0;
  for (; text < end; ++text) {
    if (!digit(*text)) return false;
    number = number * 10 + static_cast<uint32_t>(*text - '0');
  }
  return number <= 65535;
}

bool printable(const char* text) {
  for (; *text; ++text) {
    if (*text < ' ' || *text > '~' || *text == '<') return false;
  }
  return true;
}

// On small processors, printf supports neither %f nor a width of *, and divisions are so slow that
// every answer would disturb a texture. Each digit is therefore found by subtraction.
char* append_fixed(char* end, float value, int decimals) {
  float scale = 1;
  for (int i = 0; i < decimals; ++i) scale *= 10;
  int32_t left = static_cast<int32_t>(lroundf(value * scale));
  if (left < 0) {
    *end++ = '-';
    left = -left;
  }
  static const int32_t kPlaces[] = {1000000000, 100000000, 10000000, 1000000, 100000,
                                    10000,      1000,      100,      10,      1};
  bool begun = false;
  for (int place = 0; place < 10; ++place) {
    char figure = '0';
    for (; left >= kPlaces[place]; left -= kPlaces[place]) ++figure;
    begun = begun || figure != '0' || place >= 9 - decimals;
    if (begun) *end++ = figure;
    if (decimals && place == 9 - decimals) *end++ = '.';
  }
  *end = '\0';
  return end;
}

int within(const char* text, float lowest, float highest, float* value) {
  if (!parse_number(text, value)) return kDataType;
  return *value >= lowest && *value <= highest ? kOk : kRange;
}

int whole_within(const char* text, size_t lowest, size_t highest, size_t* value) {
  float number = 0;
  const int code = within(text, static_cast<float>(lowest), static_cast<float>(highest), &number);
  if (code != kOk) return code;
  *value = static_cast<size_t>(number);
  return static_cast<float>(*value) == number ? kOk : kRange;
}

size_t split(char* text, char** pieces, size_t most) {
  if (!text || !*text) return 0;
  size_t count = 0;
  while (text) {
    if (count < most) pieces[count] = text;
    ++count;
    text = strchr(text, ',');
    if (text) *text++ = '\0';
  }
  return count;
}

}  // namespace slipscale
