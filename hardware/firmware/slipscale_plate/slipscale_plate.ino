// Reference sketch: the rules of plate_board on an Arduino-compatible board.
//
// Wiring assumed by this sketch (for another, change the Hal below):
//   AD9833 signal generator   SPI, chip select on pin 10: the carrier
//   MCP4725 converter         I2C 0x60: the amplifier's gain, 0 to 5 V for 0 to 20 V peak
//   output relay or enable    kEnable, active high, with a pull-down of 10 kΩ to ground: the output
//                             is off if it is open, also in a reset, during an upload and without power
//   vibration sensor          kSensor: an envelope detector, 0 to 5 V for 0 to 3 µm peak to peak
//   temperature               kTemperature: LM35, 10 mV per °C
//   drive current's phase     kPhase: phase detector against the carrier, 2.5 V at resonance
// If the processor's converters accept only 3.3 V (ESP32, Teensy), each of the last three inputs
// needs a divider from 5 V to 3.3 V. The converters of an ESP32 are not linear: calibrate the sensor.
// Libraries: SPI, Wire, EEPROM (all part of the Arduino cores). Boards: Arduino Uno and Leonardo,
// ESP32, Teensy 4 (processor.h).
#include <SPI.h>
#include <Wire.h>

#include "plate_board.h"
#include "processor.h"

namespace {

#if defined(ARDUINO_ARCH_ESP32)  // pins 6 to 11 are used by the flash memory
constexpr uint8_t kSelect = 5, kEnable = 25, kSensor = 34, kTemperature = 35, kPhase = 32;
#else
constexpr uint8_t kSelect = 10, kEnable = 7, kSensor = A0, kTemperature = A1, kPhase = A2;
#endif
constexpr float kClockHz = 25e6F, kFullScaleV = 20.0F, kSensorUm = 3.0F;
constexpr float kFirstHz = 30500.0F;      // from slipscale plate calibrate
constexpr float kHzPerPhaseStep = 0.05F;  // slow, to follow temperature but not noise

// The sensor's output, 0 to 5 V, before any divider.
float volts(uint8_t pin) { return analogRead(pin) * (5.0F / processor::kSteps); }

class Electronics : public slipscale::Hal {
 public:
  void begin() {
    digitalWrite(kEnable, LOW);  // before the pin becomes an output, to avoid a pulse
    pinMode(kEnable, OUTPUT);
    pinMode(kSelect, OUTPUT);
    digitalWrite(kSelect, HIGH);
    SPI.begin();
    Wire.begin();
    Wire.setClock(400000);  // a texture sets the voltage every millisecond
  }

  void drive(float frequency_hz, float voltage_v) override {
    set_voltage(voltage_v);
    set_frequency(frequency_hz);
    digitalWrite(kEnable, HIGH);
  }

  void off() override {
    digitalWrite(kEnable, LOW);
    set_voltage(0);
  }

  float amplitude_um_pp() override { return volts(kSensor) * (kSensorUm / 5.0F); }
  float temperature_c() override { return volts(kTemperature) * 100.0F; }

  float resonance_hz() override {
    if (digitalRead(kEnable) == HIGH) {
      resonance_hz_ += kHzPerPhaseStep * (volts(kPhase) - 2.5F);
      resonance_hz_ = constrain(resonance_hz_, kFirstHz - 500.0F, kFirstHz + 500.0F);
    }
    return resonance_hz_;
  }

 private:
  void set_frequency(float frequency_hz) {
    const uint32_t word = static_cast<uint32_t>(frequency_hz * (268435456.0F / kClockHz));
    SPI.beginTransaction(SPISettings(1000000, MSBFIRST, SPI_MODE2));
    digitalWrite(kSelect, LOW);
    SPI.transfer16(0x2000);  // both halves of the frequency follow
    SPI.transfer16(0x4000 | (word & 0x3FFF));
    SPI.transfer16(0x4000 | (word >> 14));
    digitalWrite(kSelect, HIGH);
    SPI.endTransaction();
  }

  void set_voltage(float voltage_v) {
    const uint16_t word = static_cast<uint16_t>(voltage_v * (4095.0F / kFullScaleV));
    Wire.beginTransmission(0x60);
    Wire.write(static_cast<uint8_t>(word >> 8));
    Wire.write(static_cast<uint8_t>(word & 0xFF));
    Wire.endTransmission();
  }

  float resonance_hz_ = kFirstHz;
};

Electronics electronics;
slipscale::Board* board = nullptr;

}  // namespace

void setup() {
  electronics.begin();
  processor::begin();
  Serial.begin(115200);
  slipscale::Settings settings;
  settings.identity = "Your laboratory,slipscale-plate-1,0001,1.2";
  static slipscale::Board the_board(electronics, settings, processor::next_boot());
  board = &the_board;
  board->silence();
  processor::watch();
}

void loop() {
  processor::alive();
  if (processor::host_is_gone()) board->silence();
  while (Serial.available() > 0) {
    const char* answer = board->receive(static_cast<uint8_t>(Serial.read()), millis());
    if (answer) Serial.print(answer);
  }
  board->tick(millis());
}
