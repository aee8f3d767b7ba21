//! Objects of the JSON answer.

/// Declares an object: each key with its meaning, its type and its value.
macro_rules! object {
    (
        $(#[$about:meta])*
        $visible:vis struct $name:ident $(<$life:lifetime>)? of $source:ident: $from:ty {
            $($(#[$meaning:meta])* $key:ident: $type:ty = $value:expr,)+
        }
    ) => {
        $(#[$about])*
        #[derive(serde::Serialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        $visible struct $name $(<$life>)? {
            $($(#[$meaning])* $key: $type,)+
        }

        impl $(<$life>)? $name $(<$life>)? {
            pub(super) fn new($source: $from) -> Self {
                Self { $($key: $value,)+ }
            }
        }
    };
}
pub(super) use object;
