#include "plate_text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

namespace slipscale {
namespace {

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

bool digit(char c) { return c >= '0' && c <= '9'; }

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

uint16_t crc16(const char* data, size_t length) {  // CRC-16/CCITT-FALSE
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < length; ++i) {
    crc ^= static_cast<uint16_t>(static_cast<uint8_t>(data[i]) << 8);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<uint16_t>((crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1);
    }
  }
  return crc;
}

// Small processors' printf knows neither %f nor a width of *.
char* append_fixed(char* end, float value, int decimals) {
  long scale = 1;
  for (int i = 0; i < decimals; ++i) scale *= 10;
  const long scaled = lroundf(value * static_cast<float>(scale));
  long left = scaled < 0 ? -scaled : scaled;
  end += sprintf(end, "%s%ld", scaled < 0 ? "-" : "", left / scale);
  if (decimals) *end++ = '.';
  for (left %= scale; scale > 1; left %= scale) {
    scale /= 10;
    *end++ = static_cast<char>('0' + left / scale);
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
