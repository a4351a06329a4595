// Numbers and checksums in the format of the protocol.
#ifndef SLIPSCALE_PLATE_TEXT_H
#define SLIPSCALE_PLATE_TEXT_H

#include <stddef.h>
#include <stdint.h>

namespace slipscale {

constexpr int kOk = 0, kDataType = -104, kMissing = -109, kUndefined = -113;
constexpr int kConflict = -221, kRange = -222, kTooHot = 101;

const char* meaning(int code);
uint16_t crc16(const char* data, size_t length);
// Whether a text, up to `end`, is a sequence number: 1 to 65535, without a leading zero.
bool sequence_number(const char* text, const char* end);
// Whether a text contains only characters that are allowed in a frame.
bool printable(const char* text);
// Write a number with `decimals` decimals (up to 4); return the end of the text.
char* append_fixed(char* end, float value, int decimals);
// Parse a number and check its limits; return kOk, kDataType or kRange.
int within(const char* text, float lowest, float highest, float* value);
// The same for an integer.
int whole_within(const char* text, size_t lowest, size_t highest, size_t* value);
// Split a text at its commas. Return the number of pieces; only the first `most` are stored.
size_t split(char* text, char** pieces, size_t most);

}  // namespace slipscale

#endif
