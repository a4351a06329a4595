#ifndef STUB_SPI_H
#define STUB_SPI_H
#include <Arduino.h>
constexpr uint8_t SPI_MODE2 = 8;
struct SPISettings {
  SPISettings(uint32_t clock_hz, uint8_t order, uint8_t mode);
};
struct SPIStub {
  void begin();
  void beginTransaction(SPISettings settings);
  uint16_t transfer16(uint16_t data);
  void endTransaction();
};
extern SPIStub SPI;
#endif
