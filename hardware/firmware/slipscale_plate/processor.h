// Processor-specific code: watchdog, converters, the counter of starts that survives a reset, and
// whether the processor can read the line's DTR.
#ifndef SLIPSCALE_PROCESSOR_H
#define SLIPSCALE_PROCESSOR_H

#include <Arduino.h>
#include <EEPROM.h>

#if defined(__AVR__)
#include <avr/wdt.h>
#elif defined(ARDUINO_ARCH_ESP32)
#include <esp_idf_version.h>
#include <esp_task_wdt.h>
#endif

namespace processor {


#if defined(__AVR__)

constexpr float kSteps = 1023.0F;

inline void begin() {}
inline void watch() { wdt_enable(WDTO_120MS); }
inline void alive() { wdt_reset(); }
inline void save() {}

#elif defined(ARDUINO_ARCH_ESP32)

constexpr float kSteps = 4095.0F;

inline void begin() {
  EEPROM.begin(sizeof(uint32_t));
  analogReadResolution(12);
}
inline void watch() {
#if ESP_IDF_VERSION_MAJOR >= 5
  const esp_task_wdt_config_t config = {120, 0, true};  // ms
  esp_task_wdt_reconfigure(&config);
#else
  esp_task_wdt_init(1, true);  // whole seconds only
#endif
  esp_task_wdt_add(nullptr);
}
inline void alive() { esp_task_wdt_reset(); }
inline void save() { EEPROM.commit(); }

#elif defined(__IMXRT1062__)  // Teensy 4.0, 4.1

constexpr float kSteps = 1023.0F;

inline void begin() {}
inline void watch() {
  CCM_CCGR3 |= CCM_CCGR3_WDOG1(CCM_CCGR_ON);
  WDOG1_WCR = WDOG_WCR_SRS | WDOG_WCR_WT(0) | WDOG_WCR_WDE;  // half a second, the shortest possible
}
inline void alive() {
  WDOG1_WSR = 0x5555;
  WDOG1_WSR = 0xAAAA;
}
inline void save() {}

#else
#error "processor.h: neither AVR, ESP32 nor Teensy 4; add your processor's watchdog and converters"
#endif

// Whether the computer closed the line, if the processor can detect that. On other processors, DTR
// resets the board when the port is opened again; until then, the protocol's watchdog silences it.
inline bool host_is_gone() {
#if defined(USBCON) || defined(__IMXRT1062__)  // native USB
  return !Serial.dtr();
#else
  return false;
#endif
}

// A number that differs from that of the previous start.
inline uint32_t next_boot() {
  uint32_t boot = 0;
  EEPROM.get(0, boot);
  EEPROM.put(0, ++boot);
  save();
  return boot;
}

}  // namespace processor

#endif
