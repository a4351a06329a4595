#ifndef STUB_WIRE_H
#define STUB_WIRE_H
#include <Arduino.h>
struct WireStub {
  void begin();
  void setClock(uint32_t hz);
  void beginTransmission(uint8_t address);
  size_t write(uint8_t data);
  uint8_t endTransmission();
};
extern WireStub Wire;
#endif
