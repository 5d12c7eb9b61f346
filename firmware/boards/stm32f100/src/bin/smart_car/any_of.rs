//! Pins of one kind as one type, so that they fit an array.

/// Makes an enum of pins in the same mode, which is that mode's pin.
///
/// The microcontroller's library has such a type, numbered at run time; it panics for a number above
/// 15, and this image has no panic in it.
macro_rules! any_of {
    ($(#[$doc:meta])* $name:ident: Output<$mode:ty> = $($pin:ident)|+) => {
        $(#[$doc])*
        pub(crate) enum $name { $($pin($pin<Output<$mode>>)),+ }

        impl embedded_hal::digital::ErrorType for $name {
            type Error = core::convert::Infallible;
        }

        impl embedded_hal::digital::OutputPin for $name {
            fn set_low(&mut self) -> Result<(), Self::Error> {
                match self { $(Self::$pin(pin) => pin.set_low()),+ }
                Ok(())
            }

            fn set_high(&mut self) -> Result<(), Self::Error> {
                match self { $(Self::$pin(pin) => pin.set_high()),+ }
                Ok(())
            }
        }
    };
    ($(#[$doc:meta])* $name:ident: Input<$mode:ty> = $($pin:ident)|+) => {
        $(#[$doc])*
        pub(crate) enum $name { $($pin($pin<Input<$mode>>)),+ }

        impl embedded_hal::digital::ErrorType for $name {
            type Error = core::convert::Infallible;
        }

        impl embedded_hal::digital::InputPin for $name {
            fn is_high(&mut self) -> Result<bool, Self::Error> {
                match self { $(Self::$pin(pin) => pin.is_high()),+ }
            }

            fn is_low(&mut self) -> Result<bool, Self::Error> {
                match self { $(Self::$pin(pin) => pin.is_low()),+ }
            }
        }
    };
}

pub(crate) use any_of;
