#ifndef STUB_EEPROM_H
#define STUB_EEPROM_H
#include <Arduino.h>
struct EEPROMStub {
  bool begin(size_t size);
  bool commit();
  template <typename T>
  T& get(int address, T& value);
  template <typename T>
  const T& put(int address, const T& value);
};
extern EEPROMStub EEPROM;
#endif
