// What the sketch uses of an Arduino core, declared for a compiler that has none: a build with it
// finds words and types that are wrong, not what the electronics do.
#ifndef STUB_ARDUINO_H
#define STUB_ARDUINO_H

#include <stddef.h>
#include <stdint.h>

constexpr uint8_t LOW = 0, HIGH = 1, INPUT = 0, OUTPUT = 1, MSBFIRST = 1;
constexpr uint8_t A0 = 14, A1 = 15, A2 = 16;

void pinMode(uint8_t pin, uint8_t mode);
void digitalWrite(uint8_t pin, uint8_t value);
int digitalRead(uint8_t pin);
int analogRead(uint8_t pin);
void analogReadResolution(uint8_t bits);
unsigned long millis();

template <typename T>
T constrain(T value, T lowest, T highest) {
  return value < lowest ? lowest : value > highest ? highest : value;
}

struct SerialStub {
  void begin(unsigned long baud);
  int available();
  int read();
  bool dtr();
  size_t print(const char* text);
};
extern SerialStub Serial;

#if defined(__IMXRT1062__)  // the watchdog's registers, as the Teensy core names them
extern volatile uint16_t WDOG1_WCR, WDOG1_WSR;
extern volatile uint32_t CCM_CCGR3;
constexpr uint32_t CCM_CCGR_ON = 3;
constexpr uint32_t CCM_CCGR3_WDOG1(uint32_t n) { return n << 16; }
constexpr uint16_t WDOG_WCR_SRS = 16, WDOG_WCR_WDE = 4;
constexpr uint16_t WDOG_WCR_WT(int n) { return static_cast<uint16_t>(n << 8); }
#endif

#endif
